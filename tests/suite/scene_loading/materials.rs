//! Tests MTL files and the images that they name.

use super::*;
use ssct_geometry::texture;
use ssct_scenes::{Encoding, Material, Surface};

/// Makes a folder with a textured square in the material `m` of `a.mtl`, whose statements are `mtl`.
fn with_mtl(mtl: &str) -> Folder {
    let folder = square("mtllib a.mtl\nusemtl m\nf 1/1 2/2 3/3 4/4\n");
    folder.write("a.mtl", format!("newmtl m\n{mtl}\n").as_bytes());
    folder
}

/// Returns the first material of the folder's scene.
fn material(folder: &Folder) -> Material {
    folder.scene().materials.remove(0)
}

/// The texel of a flat normal map that is tilted to the right.
const TILTED: [u8; 4] = [180, 128, 245, 255];

/// `Kd` is the albedo, clamped to 1, and the luminance of `Ks` is the reflectivity. A missing number repeats the first,
/// and a material without either is a white mirror.
#[test]
fn colours_give_albedo_and_reflectivity() {
    let coloured = material(&with_mtl("Kd 0.5 0.25 2\nKs 0.5 0.5 0.5\n"));
    assert_eq!((coloured.name.as_str(), coloured.albedo), ("m", Vec3::new(0.5, 0.25, 1.0)));
    assert!((coloured.reflectivity - 0.5).abs() < 1e-6);
    let grey = material(&with_mtl("\tKd 0.5\r\n\tks 0 1 0\r"));
    assert_eq!(grey.albedo, Vec3::splat(0.5));
    assert!((grey.reflectivity - 0.7152).abs() < 1e-6);
    let silent = material(&with_mtl("Kd spectral x.rfl\nillum 2"));
    assert_eq!((silent.albedo, silent.reflectivity, silent.roughness), (Vec3::ONE, 1.0, 0.0));
    assert_eq!(silent.surface, Surface::Lit);
}

/// `Pr` is a perceptual roughness and overrides the exponent `Ns`; values out of range are clamped.
#[test]
fn roughness_is_pr_or_the_exponent() {
    // The value for r = 0.3 stands in docs/definitions.md, "glTF".
    assert_eq!((material(&with_mtl("Pr 0.3\nNs 10")).roughness * 1e3).round(), 511.0);
    assert_eq!(material(&with_mtl("Ns 0")).roughness, 0.0);
    assert_eq!(material(&with_mtl("Ns -1")).roughness, 0.0);
    assert_eq!(material(&with_mtl("Pr 7")).roughness, 1.0);
    // An exponent α gives ϱ = 2 arccos(0.244^(1/(α + 1))).
    assert!((material(&with_mtl("Ns 100")).roughness - 0.333_94).abs() < 1e-3);
}

/// Six spellings of a path, and one that leads out of the folder of the file, find the image without a warning.
#[test]
fn images_are_found_through_backslashes_wrong_case_and_strange_folders() {
    for name in [
        "tex\\Wall.PNG",
        "TEX/wall.png",
        ".\\tex\\wall.png",
        "tex/../tex/wall.png",
        "C:\\art\\flat.png",
        "\"tex\\wall.png\"",
    ] {
        let folder = with_mtl(&format!("map_Kd {name}"));
        folder.image("tex/wall.png", 2, 3, |_, _| [9, 9, 9, 255]);
        folder.image("flat.png", 2, 3, |_, _| [9, 9, 9, 255]);
        let scene = folder.scene();
        assert_eq!(scene.warnings, [] as [&str; 0], "{name}");
        let texture = &scene.textures[scene.materials[0].albedo_map.unwrap()];
        assert_eq!((texture.width, texture.height, texture.encoding), (2, 3, Encoding::Srgb));
    }
    let upwards = Folder::new(&[("models/a.obj", &format!("{SQUARE}mtllib a.mtl\nusemtl m\nf 1 2 3\n"))]);
    upwards.write("models/a.mtl", b"newmtl m\nmap_Kd ../shared/x.png\n");
    upwards.image("shared/x.png", 1, 1, |_, _| [9; 4]);
    assert_eq!(upwards.load("models/a.obj", &LEFT).unwrap().textures.len(), 1);
}

/// PNG, JPEG, TGA and BMP are decoded, also a PNG whose name ends in `.jpg`: the content says the format.
#[test]
fn each_format_is_decoded_even_under_a_wrong_name() {
    for name in ["x.png", "x.jpg", "x.tga", "x.bmp"] {
        let folder = with_mtl(&format!("map_Kd {name}"));
        let path = folder.path(name);
        image::RgbImage::from_pixel(4, 4, image::Rgb([200, 100, 50])).save(path).unwrap();
        let scene = folder.scene();
        let texel = &scene.textures[0].rgba[..4];
        assert!(texel.iter().zip([200, 100, 50, 255]).all(|(a, b)| a.abs_diff(b) < 6), "{name}: {texel:?}");
    }
    let folder = with_mtl("map_Kd really-png.jpg");
    folder.image("x.png", 1, 1, |_, _| [1, 2, 3, 255]);
    std::fs::rename(folder.path("x.png"), folder.path("really-png.jpg")).unwrap();
    assert_eq!(folder.scene().textures[0].rgba, [1, 2, 3, 255]);
}

/// A missing image gets one warning, even if it is named several times, and the material falls back to a colour. Images
/// of unused materials are not looked for.
#[test]
fn a_missing_image_is_one_warning_and_a_fallback() {
    let folder = square("mtllib a.mtl\nusemtl m\nf 1/1 2/2 3/3\nusemtl n\nf 1/1 3/3 4/4\n");
    let mtl = "newmtl m\nKd 0.5 0.5 0.5\nmap_Kd gone.png\nmap_d mask.png\nbump gone.png\n\
        newmtl n\nmap_Kd gone.png\nmap_Ks shine.png\nnewmtl unused\nmap_Kd never.png\n";
    folder.write("a.mtl", mtl.as_bytes());
    let scene = folder.scene();
    assert_sound(&scene);
    assert_eq!(
        folder.warnings(&scene),
        [
            "a.mtl:3: image gone.png is missing; the material's colour takes its place",
            "a.mtl:4: image mask.png is missing; the surface is opaque",
            "a.mtl:8: image shine.png is missing; white takes its place",
        ]
    );
    let material = &scene.materials[0];
    assert_eq!(
        (material.albedo, material.albedo_map, material.alpha_mask, material.normal_map),
        (Vec3::splat(0.5), None, None, None)
    );
    assert_eq!((scene.materials.len(), scene.materials[1].reflectivity_map), (2, None));
}

/// An image that cannot be decoded gets a warning and is left out, and the scene loads.
#[test]
fn an_image_that_cannot_be_decoded_is_a_warning() {
    let folder = with_mtl("map_Kd broken.png");
    folder.write("broken.png", b"\x89PNG\r\n\x1a\nnot really");
    let scene = folder.scene();
    assert_eq!((scene.warnings.len(), scene.materials[0].albedo_map), (1, None));
    assert!(folder.warnings(&scene)[0].starts_with("a.mtl:2: image broken.png cannot be used (broken.png: cannot be"));
}

/// A TGA of 18 bytes that claims 65535 × 65535 texels gets a warning, before 12 GB are allocated for it.
#[test]
fn an_image_of_absurd_size_is_refused_before_it_is_allocated() {
    let folder = with_mtl("map_Kd huge.tga");
    // An uncompressed 24-bit TGA that claims 65535 x 65535 texels.
    let mut header = [0_u8; 18];
    header[2] = 2;
    header[12..16].fill(0xff);
    header[16] = 24;
    folder.write("huge.tga", &header);
    let scene = folder.scene();
    assert_eq!((scene.warnings.len(), scene.textures.len()), (1, 0), "{:?}", scene.warnings);
}

/// The five statements for bumps take a normal map as it is. A grey image is a height field and becomes a normal map.
#[test]
fn bump_is_a_normal_map_or_a_height_field_by_its_content() {
    for statement in ["bump n.png", "map_bump n.png", "map_Bump n.png", "norm n.png", "bump -bm 1 n.png"] {
        let folder = with_mtl(statement);
        folder.image("n.png", 8, 8, |_, _| TILTED);
        let scene = folder.scene();
        let map = &scene.textures[scene.materials[0].normal_map.unwrap()];
        assert_eq!((&map.rgba[..4], map.encoding), (&TILTED[..], Encoding::Linear), "{statement}");
    }
    let heights = with_mtl("bump h.png");
    heights.image("h.png", 8, 8, |x, _| [(x * 30) as u8, (x * 30) as u8, (x * 30) as u8, 255]);
    let scene = heights.scene();
    let map = &scene.textures[scene.materials[0].normal_map.unwrap()];
    assert!(texture::is_normal_map(map));
    assert!(map.rgba[4 * 3] < 120 && map.rgba[4 * 3 + 2] > 200, "the rise to the right leans to the left");
}

/// `norm` names a normal map, whatever it looks like. The slope of this one is too steep to be told by its look, and
/// `bump` takes it for heights, which are all equal.
#[test]
fn norm_is_a_normal_map_by_its_name() {
    let steep = [230, 128, 204, 255];
    for (statement, texel) in [("norm n.png", steep), ("bump n.png", [128, 128, 255, 255])] {
        let folder = with_mtl(statement);
        folder.image("n.png", 8, 8, |_, _| steep);
        let scene = folder.scene();
        let map = &scene.textures[scene.materials[0].normal_map.unwrap()];
        assert_eq!((&map.rgba[..4], map.encoding), (&texel[..], Encoding::Linear), "{statement}");
    }
}

/// The option `-bm` scales the tilt of a normal map: half of it at 0.5, and none at 0.
#[test]
fn bm_scales_the_tilt() {
    let red = |statement: &str| {
        let folder = with_mtl(statement);
        folder.image("n.png", 8, 8, |_, _| TILTED);
        folder.scene().textures[0].rgba[0]
    };
    let (full, half, none) = (red("bump n.png"), red("bump -bm 0.5 n.png"), red("bump -bm 0 n.png"));
    assert!(full > half + 10 && half > none + 10, "{full} {half} {none}");
    assert_eq!(none, 128);
}

/// An image that serves as colour and as bumps becomes two textures, since only one of them is sRGB. Two materials
/// share the texture of one role.
#[test]
fn one_image_in_two_roles_is_two_textures_and_in_two_materials_one() {
    let folder = square("mtllib a.mtl\nusemtl m\nf 1/1 2/2 3/3\nusemtl n\nf 1/1 3/3 4/4\n");
    folder.write("a.mtl", b"newmtl m\nmap_Kd x.png\nbump x.png\nnewmtl n\nmap_Kd x.png\n");
    folder.image("x.png", 4, 4, |x, _| [x as u8 * 60, 0, 0, 255]);
    let scene = folder.scene();
    assert_eq!(scene.textures.len(), 2);
    assert_eq!(scene.materials[0].albedo_map, scene.materials[1].albedo_map);
    assert_ne!(scene.materials[0].albedo_map, scene.materials[0].normal_map);
}

/// A mask takes the alpha or the brightness of its image, and an image of specular colour is decoded from sRGB to one
/// linear channel.
#[test]
fn masks_and_specular_maps_are_linear_grey() {
    let folder = with_mtl("map_d alpha.png\nmap_Ks spec.png\nKs 0.5 0.5 0.5");
    folder.image("alpha.png", 2, 1, |x, _| [255, 255, 255, if x == 0 { 0 } else { 255 }]);
    folder.image("spec.png", 1, 1, |_, _| [188, 188, 188, 255]);
    let scene = folder.scene();
    let material = &scene.materials[0];
    let (mask, spec) =
        (&scene.textures[material.alpha_mask.unwrap()], &scene.textures[material.reflectivity_map.unwrap()]);
    assert_eq!((mask.rgba[0], mask.rgba[4], mask.encoding), (0, 255, Encoding::Linear));
    assert!(spec.rgba[0].abs_diff(128) <= 1 && (material.reflectivity - 0.5).abs() < 1e-6);
    let grey = with_mtl("map_d -imfchan l grey.png");
    grey.image("grey.png", 1, 1, |_, _| [40, 40, 40, 255]);
    assert_eq!(grey.scene().textures[0].rgba[0], 40);
}

/// A black `Kd` beside an image of the colour counts as white, since some exporters write 0 there; without an image it
/// is black.
#[test]
fn black_kd_under_a_map_counts_as_white() {
    let folder = with_mtl("Kd 0 0 0\nmap_Kd x.png");
    folder.image("x.png", 1, 1, |_, _| [9; 4]);
    assert_eq!(material(&folder).albedo, Vec3::ONE);
    assert_eq!(material(&with_mtl("Kd 0 0 0")).albedo, Vec3::ZERO);
}

/// The options of an MTL map that move or scale texture coordinates, or change the image, get a warning, and the image
/// is used without them.
#[test]
fn options_that_are_not_supported_say_so() {
    for (line, options) in
        [("map_Kd -s 2 2 1 x.png", "-s, -o and -t"), ("map_Kd -mm 0.5 0.1 x.png", "-mm, -imfchan and -clamp")]
    {
        let folder = with_mtl(line);
        folder.image("x.png", 1, 1, |_, _| [9; 4]);
        let expected = format!("a.mtl:2: material m: the options {options} of maps are not supported and were ignored");
        assert_eq!(folder.warnings(&folder.scene()), [expected]);
    }
}

/// A missing MTL file, a file that names no library, and an undefined material each get a warning, and the material is
/// white.
#[test]
fn missing_libraries_and_undefined_materials_are_warnings() {
    let folder = square("mtllib gone.mtl\nusemtl m\nf 1 2 3\n");
    let scene = folder.scene();
    assert_eq!(folder.warnings(&scene), ["a.obj:9: the MTL file gone.mtl is missing; its materials are white"]);
    assert_eq!((scene.materials[0].name.as_str(), scene.materials[0].albedo), ("m", Vec3::ONE));

    let folder = square("usemtl m\nf 1 2 3\n");
    assert_eq!(
        folder.warnings(&folder.scene()),
        ["a.obj: uses materials but names no MTL file; the materials are white"]
    );

    let folder = with_mtl("Kd 1 0 0");
    folder.write("a.obj", format!("{SQUARE}mtllib a.mtl\nusemtl other\nf 1 2 3\n").as_bytes());
    assert_eq!(folder.warnings(&folder.scene()), ["a.obj: material other is not defined in any MTL file; it is white"]);

    assert_eq!(square("f 1 2 3\n").scene().warnings, [] as [&str; 0]);
}

/// The line `mtllib` may name one file whose name has blanks, or several files. Material names may have blanks, and a
/// file is found in another case.
#[test]
fn libraries_may_have_blanks_in_their_name_or_be_several() {
    let folder = square("mtllib a b.mtl\nmtllib c.mtl D.MTL\nusemtl x\nf 1 2 3\nusemtl y y\nf 1 3 4\n");
    folder.write("a b.mtl", b"newmtl x\nKd 0.1 0.1 0.1\n");
    folder.write("c.mtl", b"newmtl z\n");
    folder.write("d.mtl", b"newmtl y y\nKd 0.2 0.2 0.2\n");
    let scene = folder.scene();
    let albedos: Vec<_> = scene.materials.iter().map(|m| m.albedo.x).collect();
    assert_eq!((albedos, scene.warnings.len()), (vec![0.1, 0.2], 0));
}

/// Names in Latin-1 are read: the material is found by its bytes, the mesh's name is shown as Latin-1, and only the
/// missing image gets a warning.
#[test]
fn names_need_not_be_utf_8() {
    let folder = square("");
    let text = [SQUARE.as_bytes(), b"mtllib a.mtl\no caf\xe9\nusemtl stra\xdfe\nf 1 2 3\n"].concat();
    folder.write("a.obj", &text);
    folder.write("a.mtl", b"newmtl stra\xdfe\nKd 0.1 0.1 0.1\nmap_Kd \xe9.png\n");
    let scene = folder.scene();
    assert_eq!((scene.materials[0].albedo.x, scene.warnings.len()), (0.1, 1));
    assert_eq!(scene.meshes[0].name, "café");
}
