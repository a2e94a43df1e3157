//! Loads strands from files, or generates them.
use super::{
    SceneError,
    document::StrandsTable,
    error::quoted,
    fur::Fur,
    limits::Limit,
    loader::Loader,
    loader_files::add_skipped,
    particles::{self, StrandFile},
    plain::nearest,
    rig::Moving,
};
use gobo::model::{Material, Shape, Strand};
use std::{ops::Range, path::Path, sync::Arc};
use toml::Spanned;

impl Loader<'_> {
    pub(super) fn strands(
        &mut self,
        table: &Spanned<StrandsTable>,
        is_keyed: bool,
    ) -> Result<(), SceneError> {
        let (span, given) = (&table.span(), table.get_ref());
        let material = self.strand_material(span, &given.material)?;
        let key = if given.file.is_some() { "file" } else { "generate" };
        let id = self.scene.materials.len() as u32;
        let strands = match (&given.file, &given.generate) {
            (Some(file), None) => {
                let path = self.folder.join(file);
                let read = self.strand_file(&path, &material, given.radius, id);
                read.map_err(|error| self.named_by(span, key, error))?
            }
            (None, Some(fur)) => {
                if given.radius.is_some() {
                    let help = "move it into the table of generate";
                    return Err(self.error(span, "radius", "radius beside generate", help));
                }
                self.check_limit(
                    Limit::Capsules,
                    self.capsules(),
                    fur.capsules() as usize,
                    (span, key),
                )?;
                self.fur(span, fur, id)?
            }
            _ => {
                let message = "strands need either a file or generate";
                return Err(self.error(span, "file", message, "give one of the two"));
            }
        };
        let more = strands.iter().map(|strand| strand.vertices.len()).sum();
        self.check_limit(Limit::Capsules, self.capsules(), more, (span, key))?;
        let (world, most) = (given.placement.at(0.0), material.transfer.max_color());
        self.add_material(material, (span, key))?;
        let (first_strand, mut local) = (self.scene.strands.len(), Vec::new());
        for strand in strands {
            let placed = strand.placed(&world);
            match placed.problem(most) {
                None => {
                    self.scene.strands.push(placed);
                    local.extend(is_keyed.then_some(strand));
                }
                Some(reason) => *self.scene.skipped.entry(reason).or_default() += 1,
            }
        }
        let moving = is_keyed.then(|| Moving {
            strands: Arc::new(local),
            first_strand,
            ..Moving::none(given.placement.clone())
        });
        self.place("strands", span, given.name.as_ref(), 0..0, moving)
    }

    /// The material of that name, for strands.
    pub(super) fn strand_material(
        &self,
        span: &Range<usize>,
        name: &str,
    ) -> Result<Material, SceneError> {
        let named = &self.scene.materials[self.material_of_grains(span, name)? as usize];
        let problem = [
            (named.is_volume(), "strands have no volume", "remove its attenuation"),
            (named.texture.is_some(), "strands have no texture", "remove it"),
            (named.reflectivity > 0.0, "strands have no reflectivity", "remove it"),
        ];
        if let Some((_, message, help)) = problem.into_iter().find(|problem| problem.0) {
            return Err(self.error(span, "material", message, help));
        }
        Ok(Material { shape: Shape::Capsule, ..named.clone() })
    }

    /// Adds a material that the file does not name; returns its index.
    pub(super) fn add_material(
        &mut self,
        material: Material,
        place: (&Range<usize>, &str),
    ) -> Result<u32, SceneError> {
        let index = self.scene.materials.len();
        self.check_limit(Limit::Materials, index, 1, place)?;
        self.scene.materials.push(material);
        Ok(index as u32)
    }

    /// Vertices of all strands.
    pub(super) fn capsules(&self) -> usize {
        self.scene.strands.iter().map(|strand| strand.vertices.len()).sum()
    }

    fn strand_file(
        &mut self,
        path: &Path,
        material: &Material,
        radius: Option<f32>,
        id: u32,
    ) -> Result<Vec<Strand>, SceneError> {
        let StrandFile { strands, skipped, notes } =
            particles::load_strands(path, material, id, radius)?;
        add_skipped(&mut self.scene.skipped, &skipped);
        self.scene.notes.extend(notes);
        Ok(strands)
    }

    fn fur(
        &mut self,
        span: &Range<usize>,
        fur: &Fur,
        material: u32,
    ) -> Result<Vec<Strand>, SceneError> {
        let _phase = tracing::debug_span!("generate").entered();
        let known = || {
            let solid = self.placed.iter().filter(|placed| matches!(placed.kind, "shape" | "mesh"));
            solid.filter_map(|placed| Some((placed.name.as_ref()?, placed.triangles.clone())))
        };
        let Some((_, triangles)) = known().find(|(name, _)| **name == fur.on) else {
            let help = nearest(&fur.on, known().map(|(name, _)| name.as_str()));
            let help = help.unwrap_or_else(|| "give a [[shape]] or [[mesh]] this name".to_owned());
            let message = format!("no shape or mesh is named {}", quoted(&fur.on));
            return Err(self.error(span, "generate", &message, &help));
        };
        let triangles = &self.scene.triangles[triangles];
        if triangles.is_empty() {
            let help = "fur grows from triangles";
            let message = format!("{} has no triangles", quoted(&fur.on));
            return Err(self.error(span, "generate", &message, help));
        }
        let strands = fur.strands(triangles, material, self.next_id);
        self.next_id = self.next_id.wrapping_add(fur.count);
        Ok(strands)
    }
}
