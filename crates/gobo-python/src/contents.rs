//! Contents of scenes from arrays: casters, lights and the tables of a scene file.
use crate::{
    fault::Fault,
    state::{State, Wanted, check_limit, check_shape, reserve},
    tables::{only, scene_of},
};
use gobo::{
    Gaussian, Material, Particle, Shape, Triangle,
    glam::{Quat, Vec2, Vec3, Vec4},
    model::{GaussianOpacity, Skipped, VertexColor, is_closed, turn_outwards},
};
use gobo_scene::{Limit, splats};
use toml::{Table, Value};

/// Farthest coordinate of a scene [m].
pub(crate) const FARTHEST: f32 = 1e7;

/// Rows of particles, or one value for all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Particles<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) radii: &'a [f32],
    /// Colours, linear rgba.
    pub(crate) colors: &'a [[f32; 4]],
    /// Rotations [radians].
    pub(crate) rotations: &'a [f32],
}

/// The value of a row; there may be one for all.
fn of_row<T: Copy>(values: &[T], row: usize) -> T {
    values[if values.len() == 1 { 0 } else { row }]
}

/// Refuses a number of values that is neither 1 nor the number of rows.
fn check_rows(name: &str, have: usize, rows: usize) -> Result<(), Fault> {
    if have == 1 || have == rows {
        return Ok(());
    }
    let message = format!("{name} has {have} values for {rows} rows");
    Err(Fault::input(message, "give one value for all, or one for each row"))
}

/// Counts a reason.
fn count(skipped: &mut Skipped, reason: &'static str) {
    *skipped.entry(reason).or_default() += 1;
}

/// Number of additions, and of rows left out by reason.
pub(crate) type Added = (usize, Skipped);

impl State {
    pub(crate) fn add_particles(
        &mut self,
        rows: Particles<'_>,
        wanted: &Wanted,
    ) -> Result<Added, Fault> {
        let Particles { positions, radii, colors, rotations } = rows;
        check_rows("radius", radii.len(), positions.len())?;
        check_rows("color", colors.len(), positions.len())?;
        check_rows("rotation", rotations.len(), positions.len())?;
        self.check_no_emitters()?;
        check_limit(Limit::Particles, self.scene.particles.len(), positions.len())?;
        let material = self.material(wanted, ("particles", &|material| material))?;
        check_shape(&self.scene.materials[material as usize])?;
        let max_color = self.scene.materials[material as usize].transfer.max_color();
        reserve(&mut self.scene.particles, positions.len())?;
        let first_id = self.ids(positions.len());
        let have = self.scene.particles.len();
        let mut skipped = Skipped::new();
        for (row, &center) in positions.iter().enumerate() {
            let particle = Particle {
                center: center.into(),
                radius: of_row(radii, row),
                color: of_row(colors, row).into(),
                rotation: of_row(rotations, row),
                material,
                id: first_id.wrapping_add(row as u32),
            };
            match particle.problem(max_color) {
                None => self.scene.particles.push(particle),
                Some(reason) => count(&mut skipped, reason),
            }
        }
        self.skip(skipped.clone());
        Ok((self.scene.particles.len() - have, skipped))
    }

    /// Also returns the rows that were left out.
    pub(crate) fn add_gaussians(
        &mut self,
        rows: Gaussians<'_>,
        wanted: &Wanted,
        kind: &KindOfSplats,
    ) -> Result<(Added, Vec<u32>), Fault> {
        let count_of_rows = rows.means.len();
        check_limit(Limit::Splats, self.scene.gaussians.len(), count_of_rows)?;
        let material = self.material(wanted, (&format!("splats {kind:?}"), &|m| kind.of(m)))?;
        let max_color = self.scene.materials[material as usize].transfer.max_color();
        let opacity = self.scene.materials[material as usize].gaussian;
        reserve(&mut self.scene.gaussians, count_of_rows)?;
        let first_id = self.ids(count_of_rows);
        let have = self.scene.gaussians.len();
        let (mut skipped, mut left_out) = (Skipped::new(), Vec::new());
        for row in 0..count_of_rows {
            let [w, x, y, z] = rows.quats[row];
            let gaussian = Gaussian {
                center: rows.means[row].into(),
                rotation: Quat::from_xyzw(x, y, z, w),
                sigma: rows.scales[row].into(),
                color: rows.colors[row].into(),
                opacity: rows.opacities[row],
                material,
                id: first_id.wrapping_add(row as u32),
            };
            let checked = splats::valid(gaussian).and_then(|gaussian| {
                gaussian.problem(max_color, opacity).map_or(Ok(gaussian), Err)
            });
            match checked {
                Ok(gaussian) => self.scene.gaussians.push(gaussian),
                Err(reason) => {
                    count(&mut skipped, reason);
                    left_out.push(row as u32);
                }
            }
        }
        self.skip(skipped.clone());
        Ok(((self.scene.gaussians.len() - have, skipped), left_out))
    }

    pub(crate) fn add_mesh(&mut self, mesh: Mesh<'_>, wanted: &Wanted) -> Result<Added, Fault> {
        let Mesh { vertices, faces, normals, uvs, colors } = mesh;
        for (name, have) in
            [("normals", normals.len()), ("uvs", uvs.len()), ("colors", colors.len())]
        {
            if have != 0 && have != vertices.len() {
                let message = format!("{name} has {have} rows for {} vertices", vertices.len());
                return Err(Fault::input(message, "give one for each vertex, or leave it out"));
            }
        }
        check_limit(Limit::Triangles, self.scene.triangles.len(), faces.len())?;
        let id = self.ids(1);
        let mut triangles = Vec::new();
        reserve(&mut triangles, faces.len())?;
        let mut skipped = Skipped::new();
        for (row, face) in faces.iter().enumerate() {
            let corner = |&index: &i64| usize::try_from(index).ok().filter(|&i| i < vertices.len());
            let [Some(a), Some(b), Some(c)] =
                [corner(&face[0]), corner(&face[1]), corner(&face[2])]
            else {
                let message = format!("face {row} is {face:?} of {} vertices", vertices.len());
                return Err(Fault::input(message, "indices of vertices start at 0"));
            };
            let corners = [a, b, c];
            let mut triangle = Triangle::flat(corners.map(|i| vertices[i]), 0);
            triangle.id = id;
            if !normals.is_empty() {
                let own = triangle.normals[0];
                triangle.normals = corners.map(|i| Vec3::from(normals[i]).normalize_or(own));
            }
            if !uvs.is_empty() {
                triangle.uvs = corners.map(|i| Vec2::from(uvs[i]));
            }
            if !colors.is_empty() {
                triangle.colors = corners.map(|i| VertexColor::new(Vec4::from(colors[i])));
            }
            match problem_of(&triangle) {
                None => triangles.push(triangle),
                Some(reason) => count(&mut skipped, reason),
            }
        }
        let added = triangles.len();
        self.add_triangles(triangles, wanted)?;
        self.skip(skipped.clone());
        Ok((added, skipped))
    }

    fn add_triangles(
        &mut self,
        mut triangles: Vec<Triangle>,
        wanted: &Wanted,
    ) -> Result<(), Fault> {
        check_limit(Limit::Triangles, self.scene.triangles.len(), triangles.len())?;
        reserve(&mut self.scene.triangles, triangles.len())?;
        let index = self.material(wanted, ("triangles", &|material| material))?;
        let material = &self.scene.materials[index as usize];
        if matches!(material.shape, Shape::Gaussian | Shape::Brick) {
            let message = format!("material {:?} is not for surfaces", material.name);
            return Err(Fault::input(message, "give them a material of their own"));
        }
        if material.is_volume() {
            if !is_closed(&triangles) {
                let message = "a volume needs an inside, and the mesh is open";
                let remedy = "use a closed mesh, or a material without attenuation_distance";
                return Err(Fault::input(message, remedy));
            }
            turn_outwards(&mut triangles);
        }
        triangles.iter_mut().for_each(|triangle| triangle.material = index);
        self.scene.triangles.append(&mut triangles);
        Ok(())
    }

    /// Adds a shape of a `[[shape]]` table, without its material.
    pub(crate) fn add_shape(&mut self, mut table: Table, wanted: &Wanted) -> Result<usize, Fault> {
        table.insert("material".to_owned(), "plain".into());
        let mut tables = only("shape", table);
        let plain = Table::from_iter([("name".to_owned(), Value::from("plain"))]);
        tables.extend(only("material", plain));
        let parsed = scene_of("shape", &tables)?;
        if !parsed.motions.is_empty() {
            let remedy = "leave its speed out, or load a scene file";
            return Err(Fault::input("shape: it moves", remedy));
        }
        let id = self.ids(1);
        let mut triangles = parsed.triangles;
        for triangle in &mut triangles {
            triangle.id = id;
            // A scene file with a small shape is re-centred.
            triangle.positions = triangle.positions.map(|position| position + parsed.origin);
        }
        let count = triangles.len();
        self.add_triangles(triangles, wanted)?;
        Ok(count)
    }

    /// Adds the light of a `[[light]]` table. Returns its index.
    pub(crate) fn add_light(&mut self, mut table: Table) -> Result<usize, Fault> {
        let index = self.scene.lights.len();
        table.entry("name").or_insert_with(|| Value::from(format!("light{index}")));
        let parsed = scene_of("light", &only("light", table))?;
        let Some(light) = parsed.lights.into_iter().next() else {
            return Err(Fault::input("light: nothing was read", "use the keys of docs/scene.md"));
        };
        let lights = &self.scene.lights;
        if lights.iter().any(|known| known.name == light.name) {
            let message = format!("a second light named {:?}", light.name);
            return Err(Fault::input(message, "give each light its own name"));
        }
        check_limit(Limit::Lights, index, 1)?;
        let viewpoints = |light: &gobo::Light| match light.area() {
            Some(_) => light.viewpoint_count() as usize,
            None => 0,
        };
        let have = lights.iter().map(viewpoints).sum();
        check_limit(Limit::Sources, have, viewpoints(&light))?;
        self.scene.lights.push(light);
        Ok(index)
    }

    /// Replaces the settings that tables of a scene file set beside contents.
    pub(crate) fn configure(&mut self, tables: &Table) -> Result<(), Fault> {
        const NAMES: [&str; 5] = ["shadow", "environment", "air", "mask", "clusters"];
        if let Some(name) = tables.keys().find(|name| !NAMES.contains(&name.as_str())) {
            let message = format!("scene: there is no table {name:?} here");
            return Err(Fault::input(message, format!("use {}", NAMES.join(", "))));
        }
        let mut tables = tables.clone();
        let takes_sun = tables.contains_key("environment") && self.scene.lights.is_empty();
        if !takes_sun {
            // A point light, so that the sun of an image stays in it.
            let kind = Table::from_iter([("kind".to_owned(), Value::from("point"))]);
            let light = kind.into_iter().chain([("position".to_owned(), Value::from(vec![0; 3]))]);
            tables.extend(only("light", light.collect()));
        }
        let parsed = scene_of("scene", &tables)?;
        if takes_sun && parsed.lights != scene_of("scene", &Table::new())?.lights {
            self.scene.lights.clone_from(&parsed.lights);
        }
        tables.remove("light");
        for name in tables.keys() {
            match name.as_str() {
                "shadow" => self.scene.shadow = parsed.shadow,
                "mask" => self.scene.mask = parsed.mask,
                "clusters" => self.scene.clusters = parsed.clusters,
                "air" => self.scene.air = parsed.air,
                _ => {
                    (self.scene.ambient, self.scene.background) =
                        (parsed.ambient, parsed.background);
                    self.scene.environment.clone_from(&parsed.environment);
                }
            }
        }
        Ok(())
    }
}

/// Rows of Gaussians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gaussians<'a> {
    pub(crate) means: &'a [[f32; 3]],
    /// Rotations w, x, y, z.
    pub(crate) quats: &'a [[f32; 4]],
    pub(crate) scales: &'a [[f32; 3]],
    pub(crate) opacities: &'a [f32],
    pub(crate) colors: &'a [[f32; 3]],
}

/// Kind of the shadow of Gaussians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KindOfSplats {
    pub(crate) neutral: bool,
    pub(crate) casts: bool,
    /// Extinction of a medium [1/m].
    pub(crate) density: Option<f32>,
}

impl KindOfSplats {
    fn of(self, material: Material) -> Material {
        let gaussian = match self.density {
            Some(density) => GaussianOpacity::Medium { density },
            None => GaussianOpacity::Splat,
        };
        let casts = material.casts && self.casts;
        Material { shape: Shape::Gaussian, gaussian, neutral: self.neutral, casts, ..material }
    }
}

/// Rows of a mesh; missing attributes are empty.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mesh<'a> {
    pub(crate) vertices: &'a [[f32; 3]],
    pub(crate) faces: &'a [[i64; 3]],
    pub(crate) normals: &'a [[f32; 3]],
    pub(crate) uvs: &'a [[f32; 2]],
    pub(crate) colors: &'a [[f32; 4]],
}

fn problem_of(triangle: &Triangle) -> Option<&'static str> {
    let Triangle { positions, normals, uvs, .. } = triangle;
    let is_finite = positions.iter().chain(normals).all(|v| v.is_finite())
        && uvs.iter().all(|uv| uv.is_finite());
    if !is_finite {
        return Some("triangle not finite");
    }
    let far = positions.iter().any(|p| p.abs().max_element() > FARTHEST);
    far.then_some("triangle too far")
}
