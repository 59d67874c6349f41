//! Tests that random damage to small files leads to an error or a sound scene, and never to a panic.

use super::*;
use proptest::prelude::*;
use ssct_scenes::scene_file;

/// The OBJ file that is damaged, with faces of every form.
const OBJ: &str = "mtllib a.mtl\ng left\nusemtl m\ns 1\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nv -1 0.5 2\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nvn 0.6 0 0.8\nf 1/1/1 2/2/2 3/3/1 4/1/2\nf 1 2 5\nf -1 -2 -3 -4 -5\n\
    usemtl n\nf 1//1 3//2 5//1\n";

/// The MTL file that is damaged, with options of maps.
const MTL: &str = "newmtl m\nKd 0.5 0.5 0.5\nKs 1 1 1\nNs 10\nmap_Kd x.png\nbump -bm 0.5 x.png\nmap_d x.png\n\
    newmtl n\nPr 0.5\nmap_Ks -s 1 1 x.png\nd 1\n";

/// The scene file that is damaged, with every kind of table.
const SCENE: &str = "name = \"n\"\nscale = 0.5\n[[mesh]]\nfile = \"a.obj\"\nsurface = \"sky\"\n[material.m]\n\
    roughness = 0.5\n[camera]\nnear = 0.1\n[[light]]\nkind = \"point\"\nposition = [1.0, 2.0, 3.0]\nenergy = 1.0\n\
    [view.a]\neye = [0.0, 0.0, 1.0]\nlook_at = [0.0, 0.0, 0.0]\nmaterials = { n = { reflectivity = 1.0 } }\n\
    [[probe]]\nname = \"p\"\nposition = [0, 0, 0]\nmin = [-1, -1, -1]\nmax = [1.0, 1.0, 1.0]\n[[impostor]]\nfile = \"x.png\"\n\
    centre = [0, 0, 0]\nhalf_u = [1, 0, 0]\nhalf_v = [0, -1, 0]\n[[area_light]]\nkind = \"sphere\"\n\
    radiance = [1, 1, 1]\ncentre = [0, 0, 0]\nradius = 1.0\n[[capture]]\nplace = [0, 1.5, 0]\nresolution = 64\n\
    near = 0.1\n[[capture]]\nplace = [0, 1, 0]\nresolution = 64\n";

/// A mutation: a place as a share of the text, a number that chooses the change, and a byte for the change.
pub type Mutation = (prop::sample::Index, u8, u8);

/// Applies mutations to a text, and returns its bytes.
pub fn mutate(text: &str, mutations: &[Mutation]) -> Vec<u8> {
    mutate_bytes(text.as_bytes(), mutations)
}

/// Applies mutations to bytes: replaces, inserts or removes a byte, or repeats some bytes.
pub fn mutate_bytes(bytes: &[u8], mutations: &[Mutation]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for (place, action, byte) in mutations {
        let index = place.index(bytes.len());
        // The byte is mostly one of which numbers and statements consist, so that many damaged texts still parse.
        let byte = if action & 8 == 0 { b"0123456789-./ \n\\e#fvnt"[usize::from(*byte) % 22] } else { *byte };
        match action % 4 {
            0 => bytes[index] = byte,
            1 => bytes.insert(index, byte),
            2 if bytes.len() > 1 => drop(bytes.remove(index)),
            _ => {
                let end = (index + usize::from(byte)).min(bytes.len());
                let copy = bytes[index..end].to_vec();
                bytes.splice(index..index, copy);
            }
        }
    }
    bytes
}

/// Returns a strategy that makes at most five mutations.
pub fn mutations() -> impl Strategy<Value = Vec<Mutation>> {
    prop::collection::vec(any::<Mutation>(), 0..6)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    /// An OBJ, an MTL and a scene file with random mutations are loaded soundly or refused, and never cause a panic.
    #[test]
    fn damaged_files_never_panic(obj in mutations(), mtl in mutations(), scene in mutations()) {
        let folder = Folder::new(&[]);
        folder.write("a.obj", &mutate(OBJ, &obj));
        folder.write("a.mtl", &mutate(MTL, &mtl));
        folder.write("a.scene.toml", &mutate(SCENE, &scene));
        folder.image("x.png", 4, 4, |x, y| [x as u8 * 60, y as u8 * 60, 255, 255]);
        if let Ok(scene) = folder.load("a.obj", &ObjOptions::default()) {
            assert_sound(&scene);
        }
        if let Ok(scene) = scene_file::load(&folder.path("a.scene.toml"), &LoadOptions::default()) {
            assert_sound(&scene);
        }
    }

    /// A damaged PNG, JPEG, TGA or BMP gives a sound scene, with a warning if it cannot be decoded, and never causes a
    /// panic.
    #[test]
    fn damaged_images_never_panic(damage in mutations(), format in 0_usize..4) {
        let name = ["x.png", "x.jpg", "x.tga", "x.bmp"][format];
        let folder = square("mtllib a.mtl\nusemtl m\nf 1/1 2/2 3/3\n");
        folder.write("a.mtl", format!("newmtl m\nmap_Kd {name}\nbump {name}\n").as_bytes());
        image::RgbImage::from_fn(8, 8, |x, y| image::Rgb([x as u8 * 30, y as u8 * 30, 200])).save(folder.path(name)).unwrap();
        let mut bytes = std::fs::read(folder.path(name)).unwrap();
        for (place, action, byte) in &damage {
            // Half of the changes are within the first 32 bytes, the header.
            let reach = if action & 1 == 0 { bytes.len() } else { bytes.len().min(32) };
            let index = place.index(reach);
            bytes[index] = *byte;
        }
        folder.write(name, &bytes);
        assert_sound(&folder.scene());
    }
}

/// The undamaged files load without a warning. If they did not, the mutations would try error paths alone.
#[test]
fn the_files_are_sound_before_they_are_damaged() {
    let folder = Folder::new(&[("a.obj", OBJ), ("a.mtl", MTL), ("a.scene.toml", SCENE)]);
    folder.image("x.png", 4, 4, |x, y| [x as u8 * 60, y as u8 * 60, 255, 255]);
    let scene = scene_file::load(&folder.path("a.scene.toml"), &LoadOptions::default()).unwrap();
    assert_eq!((scene.warnings.len(), scene.triangle_count(), scene.textures.len()), (0, 7, 5));
    assert_sound(&scene);
}
