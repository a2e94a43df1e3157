//! Seeds of files that name others, or that others name, with those beside them.
use super::{
    Reader,
    arrays::{self, Kind},
    seeds::picture,
    splats::{self, SPLATS},
};
use image::ImageFormat;
use std::{fs, io, path::Path};

/// Materials of a model, whose images are there.
const MATERIALS: &str = "newmtl red\nKa 1 1 1\nKd 0.8 0.1 0.1\nKs 0.5 0.5 0.5\nNs 30\nd 0.5\nillum 2\n\
    newmtl leaf\nKd 0.2 0.7 0.1\nKe 0 0.1 0\nPr 0.4\nPm 0.2\nmap_Kd -clamp on leaf.png\nmap_d leaf.png\n\
    newmtl glass\nKd 1 1 1\nTr 0.25\n";
const MODEL: &str = "mtllib current.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nusemtl red\n\
    f 1 2 3\nusemtl leaf\nf 1/1 3/2 4/1\nusemtl glass\nf 2 3 4\n";

/// Readers of files that need others in the folder `out`, which they are written to.
pub(super) fn readers(out: &Path) -> io::Result<Vec<Reader>> {
    fs::write(out.join("leaf.png"), picture(ImageFormat::Png)?)?;
    fs::write(out.join("model.obj"), MODEL)?;
    fs::write(out.join("voxels.raw"), arrays::bytes_of(Kind::F32, false, &arrays::values()))?;
    let nrrd =
        arrays::nrrd_of("float", "encoding: raw\nendian: little\ndata file: voxels.raw\n", &[]);
    let meta = arrays::meta_head("MET_FLOAT", false, false, "voxels.raw").into_bytes();
    let reader = |name, extension, seeds, scene: &str| Reader {
        name,
        extension,
        seeds,
        scene: Some(scene.to_owned()),
    };
    Ok(vec![
        reader("mtl", "mtl", vec![MATERIALS.into()], "[[mesh]]\nfile = \"model.obj\"\n"),
        reader("nhdr", "nhdr", vec![nrrd], "[[volume]]\nfile = \"current.nhdr\"\n"),
        reader("mhd", "mhd", vec![meta], "[[volume]]\nfile = \"current.mhd\"\n"),
        reader("sog_json", "json", sog_json(out)?, "[[splats]]\nfile = \"current.json\"\n"),
    ])
}

/// Files that name the images of a SOG, and the levels of a streamed one, in a folder with these.
fn sog_json(out: &Path) -> io::Result<Vec<Vec<u8>>> {
    let files = splats::sog_files(&SPLATS);
    fs::create_dir_all(out.join("level"))?;
    for (name, bytes) in &files {
        fs::write(out.join("level").join(name), bytes)?;
        fs::write(out.join(name), bytes)?;
    }
    let levels = r#"{"version": 1, "count": 4, "lodLevels": 2, "filenames": ["level/meta.json"],
"environment": "level/meta.json", "tree": {"children": [
{"lods": {"0": {"file": 0, "offset": 0, "count": 2}, "1": {"file": 0, "offset": 1, "count": 1}}},
{"lods": {"0": {"file": 0, "offset": 2, "count": 1}}}]}}"#;
    Ok(vec![files[0].1.clone(), levels.as_bytes().to_vec()])
}
