//! Sums of the counts that a scene's tables and the heads of its files announce, checked before anything is
//! allocated: tables that are small one by one may be too large together.
//!
//! An invalid table or file announces nothing: it is refused when it is read.
use super::{
    SceneError,
    document::{Document, ShapeTable, SplatsTable, TextureSource, VolumeTable},
    gltf::{
        announced::{self, Announced},
        file::GltfFile,
    },
    images,
    limits::Limit,
    loader::Loader,
    loader_files::MAX_SIDE,
    particles, shapes, splat_file,
    volume_frame::FileContent,
};
use std::{
    collections::{HashMap, HashSet},
    ops::Range,
    path::PathBuf,
};
use toml::Spanned;

/// Count that one key adds to a sum.
struct Claim {
    table: Range<usize>,
    key: &'static str,
    count: u64,
}

impl Claim {
    fn new(table: Range<usize>, key: &'static str, count: u64) -> Self {
        Self { table, key, count }
    }
}

impl Loader<'_> {
    /// Checks that the sums over all tables are within the limits.
    pub(super) fn check_announced(&self, document: &Document) -> Result<(), SceneError> {
        self.check_sum(Limit::Particles, &self.particles_announced(document))?;
        self.check_sum(Limit::Bricks, &self.bricks_announced(document))?;
        self.check_sum(Limit::Splats, &self.splats_announced(document))?;
        let mut triangles: Vec<Claim> = document
            .shape
            .iter()
            .map(|table| {
                let ShapeTable { kind, level, .. } = *table.get_ref();
                Claim::new(table.span(), "level", shapes::triangles_of(kind, level) as u64)
            })
            .collect();
        self.check_sum(Limit::Triangles, &triangles)?;
        let (mut textures, mut texels) = self.images_announced(document);
        self.check_sum(Limit::Textures, &textures)?;
        self.check_sum(Limit::Texels, &texels)?;
        let mut known: HashMap<PathBuf, Announced> = HashMap::new();
        for table in &document.mesh {
            let path = self.folder.join(&table.get_ref().file);
            let model = *known.entry(path).or_insert_with_key(|path| {
                GltfFile::open(path).map(|file| announced::announced(&file)).unwrap_or_default()
            });
            let part = |count| Claim::new(table.span(), "file", count);
            triangles.push(part(model.triangles));
            textures.push(part(model.textures));
            texels.push(part(model.texels));
        }
        self.check_sum(Limit::Triangles, &triangles)?;
        self.check_sum(Limit::Textures, &textures)?;
        self.check_sum(Limit::Texels, &texels)
    }

    /// Refuses the first key past the limit, with the sum of all.
    fn check_sum(&self, limit: Limit, parts: &[Claim]) -> Result<(), SceneError> {
        let whole = parts.iter().fold(0, |sum: u64, part| sum.saturating_add(part.count));
        let mut have = 0;
        for part in parts {
            have = limit.grown(have, part.count).map_err(|(mut message, help)| {
                if whole > have.saturating_add(part.count) {
                    message += &format!("; with the tables behind it {whole}");
                }
                self.error(&part.table, part.key, &message, help)
            })?;
        }
        Ok(())
    }

    fn bricks_announced(&self, document: &Document) -> Vec<Claim> {
        let mut known: HashMap<(PathBuf, bool), u64> = HashMap::new();
        let of_table = |table: &Spanned<VolumeTable>| match table.get_ref() {
            VolumeTable { generate: Some(cloud), .. } => {
                Claim::new(table.span(), "generate", cloud.most_bricks())
            }
            given @ VolumeTable { file: Some(file), .. } => {
                let content = FileContent::new(self.folder.join(file), given);
                let path = content.path(0.0);
                let is_colored = given.color_grid.is_some();
                let entry = known.entry((path, is_colored));
                let count = *entry.or_insert_with_key(|(path, _)| content.announced(path));
                Claim::new(table.span(), "file", count)
            }
            _ => Claim::new(table.span(), "file", 0),
        };
        document.volume.iter().map(of_table).collect()
    }

    fn splats_announced(&self, document: &Document) -> Vec<Claim> {
        let of_table = |table: &Spanned<SplatsTable>| {
            let given = table.get_ref();
            let count =
                given.file.as_ref().map(|file| splat_file::announced(&self.folder.join(file)));
            match given.generate {
                Some(generate) => Claim::new(table.span(), "generate", generate.count().into()),
                None => Claim::new(table.span(), "file", count.flatten().unwrap_or(0)),
            }
        };
        document.splats.iter().map(of_table).collect()
    }

    fn particles_announced(&self, document: &Document) -> Vec<Claim> {
        let of_tables = document.particles.iter().map(|table| {
            let given = table.get_ref();
            match (&given.generate, &given.file) {
                (Some(generate), _) => {
                    let count = generate.count_of(self.share);
                    Claim::new(table.span(), "generate", count)
                }
                (None, Some(file)) => {
                    let count = particles::announced(&self.folder.join(file)).unwrap_or(0);
                    let own = self.share.map_or(count, |share| share.count_of(count));
                    Claim::new(table.span(), "file", own)
                }
                (None, None) => Claim::new(table.span(), "file", 0),
            }
        });
        let of_emitters = document.emitter.iter().map(|table| {
            Claim::new(table.span(), "rate", table.get_ref().emitter.forces.most().into())
        });
        of_tables.chain(of_emitters).collect()
    }

    /// Textures of the materials, and their texels.
    fn images_announced(&self, document: &Document) -> (Vec<Claim>, Vec<Claim>) {
        let (mut textures, mut texels) = (Vec::new(), Vec::new());
        let mut known = HashSet::new();
        for table in &document.material {
            let count = match &table.get_ref().texture {
                Some(TextureSource::Noise(noise)) => u64::from(noise.size) * u64::from(noise.size),
                Some(TextureSource::File(file)) if known.insert(file) => {
                    let size = images::size_of_file(&self.folder.join(file), MAX_SIDE);
                    size.map_or(0, |[width, height]| u64::from(width) * u64::from(height))
                }
                _ => continue,
            };
            textures.push(Claim::new(table.span(), "texture", 1));
            texels.push(Claim::new(table.span(), "texture", count));
        }
        (textures, texels)
    }
}
