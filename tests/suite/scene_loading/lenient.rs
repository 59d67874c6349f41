//! Tests texts as other programs write them: encodings, names, lines of maps, and values that are no numbers. Each kind
//! of unread content in an OBJ or MTL file gets one warning.

use super::*;

/// Makes a folder with the square in the material `m` of a library with this text.
fn with_mtl(mtl: &[u8]) -> Folder {
    let folder = square("mtllib a.mtl\nusemtl m\nf 1/1 2/2 3/3 4/4\n");
    folder.write("a.mtl", mtl);
    folder
}

/// Returns the albedo of the first material, and the warnings.
fn albedo_and_warnings(folder: &Folder) -> (Vec3, Vec<String>) {
    let scene = folder.scene();
    assert_sound(&scene);
    (scene.materials[0].albedo, folder.warnings(&scene))
}

/// Byte order marks before an OBJ, an MTL or a scene file are skipped. Read as text, a mark would belong to the first
/// word and hide the first statement.
#[test]
fn byte_order_marks_are_skipped() {
    let red = "newmtl m\nKd 1 0 0\n";
    for (obj, mtl) in [("\u{feff}", ""), ("", "\u{feff}"), ("\u{feff}", "\u{feff}")] {
        let folder = Folder::new(&[("a.obj", &format!("{obj}mtllib a.mtl\nusemtl m\n{SQUARE}f 1 2 3\n"))]);
        folder.write("a.mtl", format!("{mtl}{red}").as_bytes());
        assert_eq!(albedo_and_warnings(&folder), (Vec3::X, Vec::new()), "{obj:?} {mtl:?}");
    }
    let before_a_vertex = Folder::new(&[("a.obj", &format!("\u{feff}{SQUARE}f 1 2 3\n"))]);
    assert_eq!(before_a_vertex.scene().triangle_count(), 1);
    let scene = "\u{feff}[[mesh]]\nfile = \"a.obj\"\n";
    before_a_vertex.write("a.scene.toml", scene.as_bytes());
    let path = before_a_vertex.path("a.scene.toml");
    assert_eq!(ssct_scenes::scene_file::load(&path, &LoadOptions::default()).unwrap().triangle_count(), 1);
}

/// UTF-16 and UTF-32 texts, with marks and without, are refused with the name of their encoding. Their bytes are mostly
/// valid characters, so that a parser's own error would mislead.
#[test]
fn wide_texts_are_named() {
    let folder = with_mtl(b"newmtl m\n");
    let text = format!("{SQUARE}f 1 2 3\n");
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let widest: Vec<u8> = text.chars().flat_map(|c| (c as u32).to_le_bytes()).collect();
    let marked = |mark: &[u8], text: &[u8]| [mark, text].concat();
    for (bytes, name) in [
        (marked(b"\xff\xfe", &little), "UTF-16"),
        (marked(b"\xfe\xff", &big), "UTF-16"),
        (little.clone(), "UTF-16"),
        (big, "UTF-16"),
        (widest, "UTF-32"),
    ] {
        folder.write("a.obj", &bytes);
        assert_eq!(folder.error(), format!("a.obj: is {name} text; save it as UTF-8"));
    }
    let folder = with_mtl(&little);
    assert_eq!(folder.error(), "a.mtl: is UTF-16 text; save it as UTF-8");
    folder.write("a.scene.toml", &little);
    let path = folder.path("a.scene.toml");
    let error = ssct_scenes::scene_file::load(&path, &LoadOptions::default()).unwrap_err().to_string();
    assert_eq!(folder.without_folder(&error), "a.scene.toml: is UTF-16 text; save it as UTF-8");
}

/// Two names in Latin-1 that differ in one byte above 127 stay two materials. Replacing bytes that are no UTF-8 would
/// make them equal.
#[test]
fn names_in_latin_1_stay_apart() {
    let folder = Folder::new(&[]);
    let obj = [SQUARE.as_bytes(), b"mtllib a.mtl\nusemtl ros\xe9\nf 1 2 3\nusemtl ros\xe8\nf 1 3 4\n"].concat();
    folder.write("a.obj", &obj);
    folder.write("a.mtl", b"newmtl ros\xe9\nKd 1 0 0\nnewmtl ros\xe8\nKd 0 1 0\n");
    let scene = folder.scene();
    let albedos: Vec<_> = scene.materials.iter().map(|m| m.albedo).collect();
    assert_eq!((albedos, scene.warnings.len()), (vec![Vec3::X, Vec3::Y], 0));
}

/// A line of a map may have options before and behind the file name, blanks in the name, and a comment; the named image
/// is found without a warning.
#[test]
fn lines_of_maps_have_options_before_and_behind_blanks_and_comments() {
    for (line, name) in [
        ("map_Kd -colorspace sRGB green.png", "green.png"),
        ("map_Kd green.png # the diffuse one", "green.png"),
        ("map_Kd my\\ green.png", "my green.png"),
        ("map_Kd \"my green.png\"", "my green.png"),
        ("map_Kd my green.png", "my green.png"),
        ("map_Kd green.png -clamp off", "green.png"),
        ("map_Kd -s 1 1 1 -o 0 0 0 green.png -blendu on # end", "green.png"),
        ("map_Kd -unknown 3 green.png", "green.png"),
        ("map_Kd a#b.png", "a#b.png"),
        ("map_Kd\tgreen.png\t# tab", "green.png"),
        ("map_Kd green -bm 2.png", "green -bm 2.png"),
        ("map_Kd textures\\my\\ green.png", "textures/my green.png"),
    ] {
        let folder = with_mtl(format!("newmtl m\n{line}\n").as_bytes());
        folder.image(name, 1, 1, |_, _| [0, 255, 0, 255]);
        let scene = folder.scene();
        assert_eq!(folder.warnings(&scene), [""; 0], "{line}");
        assert_eq!(scene.textures[0].rgba, [0, 255, 0, 255], "{line}");
    }
    let behind = with_mtl(b"newmtl m\nbump n.png -bm 0\n");
    behind.image("n.png", 4, 4, |_, _| [180, 128, 245, 255]);
    assert_eq!(behind.scene().textures[0].rgba[0], 128, "-bm counts behind the name, too");
}

/// Comments may follow the names of materials and libraries, and keywords may have capitals. A `#` inside a known name
/// is no comment.
#[test]
fn names_of_materials_and_libraries_may_have_comments() {
    for (obj, mtl) in [
        ("mtllib a.mtl # library\nusemtl m\n", "newmtl m\nKd 1 0 0\n"),
        ("mtllib a.mtl\nusemtl m # red\n", "newmtl m\nKd 1 0 0\n"),
        ("mtllib a.mtl\nusemtl m\n", "newmtl m # red\nKd 1 0 0 # red\n"),
        ("mtllib a.mtl\nusemtl Material #25\n", "newmtl Material\nKd 0 1 0\nnewmtl Material #25\nKd 1 0 0\n"),
        ("MTLLIB a.mtl\nUsemtl m\n", "NEWMTL m\nKD 1 0 0\n"),
    ] {
        let folder = square(&format!("{obj}f 1 2 3\n"));
        folder.write("a.mtl", mtl.as_bytes());
        assert_eq!(albedo_and_warnings(&folder), (Vec3::X, Vec::new()), "{obj:?}");
    }
    let folder = square("mtllib my\\ lib.mtl\nusemtl m\nf 1 2 3\n");
    folder.write("my lib.mtl", b"newmtl m\nKd 1 0 0\n");
    assert_eq!(albedo_and_warnings(&folder), (Vec3::X, Vec::new()));
}

/// If two MTL files define a material, the first counts.
#[test]
fn the_first_library_with_a_name_counts() {
    let folder = square("mtllib a.mtl b.mtl\nusemtl m\nf 1 2 3\n");
    folder.write("a.mtl", b"newmtl m\nKd 1 0 0\n");
    folder.write("b.mtl", b"newmtl m\nKd 0 1 0\n");
    assert_eq!(albedo_and_warnings(&folder), (Vec3::X, Vec::new()));
}

/// The statement `fo`, an older word for `f`, continues over a line end as `f` does.
#[test]
fn old_faces_continue_over_line_ends() {
    let scene = square("fo 1 2 \\\n3 4\n").scene();
    assert_eq!((scene.triangle_count(), scene.warnings.len()), (2, 0));
}

/// The keywords of an OBJ file may be capital letters.
#[test]
fn keywords_may_be_capitals() {
    let scene = Folder::new(&[("a.obj", "V -1 -1 0\nV 1 -1 0\nV 1 1 \\\n0\nVN 0 0 1\nF 1//1 2//1 3//1\n")]).scene();
    assert_eq!((scene.triangle_count(), scene.warnings.len()), (1, 0));
}

/// NaN and infinity in normals, texture coordinates and materials, and indices of missing normals, get a warning and a
/// default. Exporters write them for degenerate faces.
#[test]
fn values_that_are_no_numbers_are_left_out_with_a_warning() {
    let flat = |text: &str| {
        let folder = square(text);
        let scene = folder.scene();
        assert_sound(&scene);
        assert!(scene.meshes[0].vertices.iter().all(|v| normal(v) == Vec3::Z), "{text}");
        folder.warnings(&scene)
    };
    for word in ["nan", "NaN", "-nan", "inf", "1.#QNAN", "-1.#IND", "1.#INF", "nan(ind)", "1e99"] {
        let warnings = flat(&format!("vn {word} 0 1\nf 1//1 2//1 3//1\n"));
        assert_eq!(warnings, ["a.obj:9: normals that are not finite were made from the faces"], "{word}");
    }
    let warnings = flat("vt 0 inf\nf 1/5 2/1 3/1\n");
    assert_eq!(warnings, ["a.obj:9: texture coordinates that are not finite count as 0"]);
    let warnings = flat("f 1//1 2//2 3//3\nvn 0 0 1\n");
    assert_eq!(warnings, ["a.obj:9: a face refers to normals that are not there; they were made from the faces"]);
    let warnings = flat("f 1/9 2/-7 3/1\n");
    assert_eq!(warnings, ["a.obj:9: a face refers to texture coordinates that are not there; they count as 0"]);
    for (statement, rest) in [("Ns -1.#IND", ""), ("Kd nan 0 0", ""), ("Pr inf", ""), ("Ks 1 1 1e99", "")] {
        let (albedo, warnings) = albedo_and_warnings(&with_mtl(format!("newmtl m\n{statement}\n{rest}").as_bytes()));
        assert_eq!(warnings, ["a.mtl:2: a statement with a number that is not finite was ignored"], "{statement}");
        assert_eq!(albedo, Vec3::ONE);
    }
}

/// In an MTL file, a word in place of a number, a decimal comma, and a colour of two numbers count as missing, with a
/// warning. A file that is refused for one statement would show nothing.
#[test]
fn words_of_materials_that_are_no_numbers_count_as_missing() {
    let word = "a statement whose value is no number was ignored";
    let comma = "a statement with a decimal comma was ignored; MTL files have decimal points";
    let two = "a colour that has neither one number nor three was ignored";
    for (statement, warning) in [
        ("Kd 1 x 1", word),
        ("Kd 0,5 0,5 0,5", comma),
        ("Kd 0.5 0.5", two),
        ("Ks", two),
        ("Ks 1 none 1", word),
        ("Ns", word),
        ("Pr 0,5", comma),
        ("Pm much", word),
        ("Ni 1,8", comma),
        ("Ke 1,5 0 0", comma),
        ("Ka red", word),
        ("illum two", word),
    ] {
        let folder = with_mtl(format!("newmtl m\n{statement}\n").as_bytes());
        assert_eq!(albedo_and_warnings(&folder), (Vec3::ONE, vec![format!("a.mtl:2: {warning}")]), "{statement}");
    }
}

/// Each kind of statement that is not supported gets one warning, even if it occurs twice. Statements that change
/// nothing get none.
#[test]
fn each_kind_of_loss_is_one_warning() {
    let warnings = |mtl: &str| {
        let (_, warnings) = albedo_and_warnings(&with_mtl(format!("newmtl m\n{mtl}\n").as_bytes()));
        warnings
    };
    for (lost, about) in [
        ("d 0", "transparency"),
        ("d -halo 0.5", "transparency"),
        ("Tr 0.5", "transparency"),
        ("Tf 0 1 0", "transparency"),
        ("map_Ns x.png", "images of exponents"),
        ("Pc 0.5", "sheen"),
        ("aniso 0.5", "sheen"),
        ("refl -type sphere x.png", "reflection maps"),
        ("disp x.png", "displacement"),
        ("Kd spectral x.rfl", "colours as spectral curves"),
        ("Ke 10", "emission brighter than 1"),
        ("map_Kn x.png\nmap_Tr x.png", "a statement is unknown"),
    ] {
        // Twice is still one warning.
        let warnings = warnings(&format!("{lost}\n{lost}"));
        assert!(warnings.len() == 1 && warnings[0].starts_with(&format!("a.mtl:2: {about}")), "{lost}: {warnings:?}");
    }
    let kept = "d 1\nTr 0\nTf 1 1 1\nKe 0 0 0\nPs 0\nPc 0\nPcr 0.03\naniso 0\nanisor 0.5\nKa 1 1 1\nNi 1.5\nillum 2\n\
        sharpness 60\nmap_Ka x.png\n";
    assert_eq!(warnings(kept), [""; 0], "statements that change nothing");
    let two = warnings("d 0\ndisp x.png");
    assert_eq!(two.len(), 2, "{two:?}");
    let unused = square("mtllib a.mtl\nusemtl m\nf 1 2 3\n");
    unused.write("a.mtl", b"newmtl m\nnewmtl other\nd 0\n");
    let (_, no_warnings) = albedo_and_warnings(&unused);
    assert_eq!(no_warnings, [""; 0], "materials that are not used get no warning");

    let warnings = |obj: &str| {
        let folder = square(&format!("{obj}f 1 2 3\n"));
        folder.warnings(&folder.scene())
    };
    for (lost, about) in [
        ("v 5 5 5 1 0 0\nv 5 5 5 1 0 0\n", "colours of vertices"),
        ("l 1 2\np 1\nl 2 3\n", "lines and points"),
        ("vp 0.1 0.2\ncstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nend\n", "curves and free-form surfaces"),
        ("usemap x\nmaplib y\n", "usemap and maplib"),
        ("call b.obj\ncall c.obj 1 2\n", "files that the statement call names"),
        ("nonsense 1 2\nwhatever\n", "a statement is unknown"),
    ] {
        let warnings = warnings(lost);
        assert!(warnings.len() == 1 && warnings[0].starts_with(&format!("a.obj:9: {about}")), "{lost}: {warnings:?}");
    }
    assert_eq!(warnings("# c\nbevel on\nlod 3\nshadow_obj x\ns 1\ng a\no b\nv 5 5 5 1.0\n"), [""; 0], "hints");
}
