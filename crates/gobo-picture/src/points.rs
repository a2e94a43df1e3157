//! Share of each light that reaches points.
use super::{
    Engine, Renderer, check,
    engine::{GpuEngine, settings},
    place_order::place_order,
    without_emissions,
};
use glam::Vec3;
use gobo::{
    Error,
    model::{ReceiverPoint, Scene, View},
    records::ViewMaps,
    shadows::{PointBuffers, Prepared, check as check_views},
    view::{Receivers, atlas::AtlasLimits, picture_views, views_around},
};
use gobo_reference as reference;

/// Maps of a scene, in which light is looked up for any number of points, some at a time.
#[derive(Debug)]
pub struct PointLookUp<'a> {
    scene: &'a Scene,
    maps: Maps<'a>,
}

#[derive(Debug)]
enum Maps<'a> {
    Gpu(&'a mut GpuEngine, Box<Prepared>),
    Cpu { receivers: Receivers, views: Vec<View>, maps: Vec<ViewMaps> },
}

impl Renderer {
    /// Share of each light that reaches each point of the world: linear rgb, point by point, in the scene's
    /// order of lights; 1 if nothing is in between, without falloff and cosine. 0 beyond a light's
    /// [`Light::far`](gobo::Light::far), where it has one.
    pub fn light_points(
        &mut self,
        scene: &Scene,
        points: &[ReceiverPoint],
    ) -> Result<Vec<[f32; 3]>, Error> {
        let mut receivers = Receivers::default();
        receivers.extend(points.iter().map(|point| point.position));
        self.point_look_up(scene, receivers)?.shares(points)
    }

    /// Renders the maps for [`PointLookUp::shares`]. `receivers`: all points that will be asked for.
    pub fn point_look_up<'a>(
        &'a mut self,
        scene: &'a Scene,
        receivers: Receivers,
    ) -> Result<PointLookUp<'a>, Error> {
        let receivers = receivers.moved(-scene.origin);
        self.look_up(scene, receivers, views_around)
    }

    /// Look-up in the maps of the scene's picture, for points in its bounds.
    pub(super) fn picture_look_up<'a>(
        &'a mut self,
        scene: &'a Scene,
    ) -> Result<PointLookUp<'a>, Error> {
        self.look_up(scene, Receivers::default(), |scene, limits, _| picture_views(scene, limits))
    }

    fn look_up<'a>(
        &'a mut self,
        scene: &'a Scene,
        receivers: Receivers,
        fit: impl Fn(&Scene, &AtlasLimits, &Receivers) -> (Vec<View>, usize),
    ) -> Result<PointLookUp<'a>, Error> {
        check(scene)?;
        let maps = match &mut self.engine {
            Engine::Gpu(engine) => {
                let limits = AtlasLimits::of(&engine.gpu.device.limits());
                let prepared = engine.point_maps(scene, &fit(scene, &limits, &receivers).0);
                let prepared = prepared.map_err(|error| engine.cause_of(error))?;
                Maps::Gpu(engine, Box::new(prepared))
            }
            Engine::Cpu => {
                without_emissions(scene)?;
                let (views, _) = fit(scene, &AtlasLimits::CORE, &receivers);
                check_views(&views, &scene.shadow)?;
                let (maps, _) = reference::render_maps(scene, &views);
                Maps::Cpu { receivers, views, maps }
            }
        };
        Ok(PointLookUp { scene, maps })
    }
}

impl PointLookUp<'_> {
    /// Shares as of [`Renderer::light_points`], for points that are among the receivers.
    pub fn shares(&mut self, points: &[ReceiverPoint]) -> Result<Vec<[f32; 3]>, Error> {
        let origin = self.scene.origin;
        let moved =
            |point: &ReceiverPoint| ReceiverPoint { position: point.position - origin, ..*point };
        self.own_shares(&points.iter().map(moved).collect::<Vec<_>>())
    }

    /// Like [`Self::shares`], for points relative to the scene's origin.
    pub(super) fn own_shares(&mut self, points: &[ReceiverPoint]) -> Result<Vec<[f32; 3]>, Error> {
        let scene = self.scene;
        match &mut self.maps {
            Maps::Gpu(engine, prepared) => {
                let shares = engine.light_points(scene, prepared, points);
                shares.map_err(|error| engine.cause_of(error))
            }
            Maps::Cpu { receivers, views, maps } => {
                let fit = |scene: &Scene| views_around(scene, &AtlasLimits::CORE, receivers).0;
                Ok(reference::light_points(scene, views, maps, &fit, points))
            }
        }
    }
}

impl GpuEngine {
    fn point_maps(&mut self, scene: &Scene, views: &[View]) -> Result<Prepared, Error> {
        self.emit(scene)?;
        let (prepared, _) =
            self.shade_maps(scene, views, &settings(scene, false), |_, _| Ok(()))?;
        Ok(prepared)
    }

    /// Looks up as many points at once as a buffer holds.
    fn light_points(
        &self,
        scene: &Scene,
        prepared: &Prepared,
        points: &[ReceiverPoint],
    ) -> Result<Vec<[f32; 3]>, Error> {
        /// Most points that are looked up at once.
        const MAX: usize = 1 << 22;
        let limits = self.gpu.device.limits();
        let chosen: Vec<_> = (0..scene.lights.len()).collect();
        let answers = limits.max_storage_buffer_binding_size as usize / size_of::<[f32; 3]>();
        let at_a_time = (answers / chosen.len().max(1)).clamp(1, MAX);
        let order = place_order(points.iter().map(|point| point.position));
        let mut shares = vec![[0.0; 3]; points.len() * chosen.len()];
        for some in order.chunks(at_a_time) {
            let upload = |of: fn(&ReceiverPoint) -> Vec3| {
                let vectors = some.iter().map(|&i| of(&points[i as usize]).into());
                let vectors: Vec<[f32; 3]> = vectors.collect();
                self.gpu.upload("points", &vectors, wgpu::BufferUsages::STORAGE)
            };
            let (positions, normals) =
                (upload(|point| point.position), upload(|point| point.normal));
            let count = some.len() as u32;
            let buffers = PointBuffers { count, positions: &positions, normals: Some(&normals) };
            let lit = prepared.some_light_points(&scene.lights, &chosen, &buffers)?;
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            lit.record(&mut encoder);
            self.gpu.queue.submit([encoder.finish()]);
            let read: Vec<[f32; 3]> = self.gpu.try_read(lit.shares())?;
            for (&i, row) in some.iter().zip(read.chunks_exact(chosen.len().max(1))) {
                let first = i as usize * chosen.len();
                shares[first..first + chosen.len()].copy_from_slice(row);
            }
        }
        Ok(shares)
    }
}
