//! Every error of OBJ and MTL files: one sentence with the file and, where there is one, the line.

use super::*;

#[test]
fn errors_name_file_line_and_cause() {
    let cases = [
        ("v nan 0 0\n", "a.obj:9: \"nan\" in a vertex is not finite"),
        ("v 0 -inf 0\n", "a.obj:9: \"-inf\" in a vertex is not finite"),
        ("\nv 0 1e99 0\n", "a.obj:10: \"1e99\" in a vertex is not finite"),
        ("vn 0 NaN 0\n", "a.obj:9: \"NaN\" in a normal is not finite"),
        ("vt 0 inf\n", "a.obj:9: \"inf\" in a texture coordinate is not finite"),
        ("v 1 2\n", "a.obj:9: a vertex ends after 2 numbers; it needs 3"),
        ("vt\n", "a.obj:9: a texture coordinate ends after 0 numbers; it needs 1"),
        ("v 1 2 x\n", "a.obj:9: \"x\" in a vertex is not a number"),
        ("f 1 2 5\n", "a.obj:9: a face refers to vertex 5, but there are 4"),
        ("f 1 2 3\nf 1 2 -5\n", "a.obj:10: a face refers to vertex -5, but there are 4"),
        ("f 1 2 0\n", "a.obj:9: a face refers to vertex 0, but there are 4"),
        ("f 1/1 2/2 3/9\n", "a.obj:9: a face refers to texture coordinate 9, but there are 4"),
        ("f 1//1 2 3\n", "a.obj:9: a face refers to normal 1, but there are 0"),
        ("f 1 2 99999999999\n", "a.obj:9: a face refers to vertex 99999999999, but there are 4"),
        ("f 1 2 99999999999999999999\n", "a.obj:9: \"99999999999999999999\" in a face is not of the form v/vt/vn"),
        ("f 1 2 3/1/1/1\n", "a.obj:9: \"3/1/1/1\" in a face is not of the form v/vt/vn"),
        ("f 1 2 /1\n", "a.obj:9: \"/1\" in a face is not of the form v/vt/vn"),
        ("f 1 2 three\n", "a.obj:9: \"three\" in a face is not of the form v/vt/vn"),
        ("f\n", "a.obj:9: a face has no corners"),
        ("", "a.obj: there are no faces in this file"),
        ("f 1 2\nl 1 2 3\n", "a.obj: there are no faces in this file"),
        ("f 1 1 1\n", "a.obj: no face of this file has an area"),
        ("v 1e30 0 0\nf 1 3 5\n", "a.obj: a vertex lies more than 1e8 m from the origin"),
    ];
    for (rest, expected) in cases {
        assert_eq!(square(rest).error(), expected, "{rest:?}");
    }
}

#[test]
fn faces_of_too_many_corners_are_refused() {
    let face = format!("f{}\n", " 1".repeat(1025));
    assert_eq!(square(&face).error(), "a.obj:9: a face has 1025 corners, more than 1024");
}

#[test]
fn missing_empty_and_huge_files_are_refused() {
    let folder = square("f 1 2 3\n");
    let missing = folder.load("b.obj", &LEFT).unwrap_err().to_string();
    assert!(folder.without_folder(&missing).starts_with("cannot read b.obj: "), "{missing}");
    folder.write("a.obj", b"");
    assert_eq!(folder.error(), "a.obj: there are no faces in this file");
    std::fs::File::create(folder.path("a.obj")).unwrap().set_len(3 << 30).unwrap();
    assert_eq!(folder.error(), "a.obj: a file of 3221225472 bytes is too large; at most 1073741824 bytes are read");
}

#[test]
fn wrong_arguments_are_usage_errors() {
    let folder = square("f 1 2 3\n");
    for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = folder.load("a.obj", &ObjOptions { load: scaled(scale), ..LEFT }).unwrap_err();
        assert!(matches!(error, ssct::error::Error::Usage(_)), "{error}");
        assert_eq!(error.to_string(), format!("the scale must be a positive number, not {scale}"));
    }
    assert_eq!(obj::load(&[], &LEFT).unwrap_err().to_string(), "a scene needs at least one OBJ file");
}

#[test]
fn wrong_numbers_in_an_mtl_file_name_its_line() {
    let cases = [
        ("Kd 1 x 1", "a.mtl:2: kd needs a finite number, not \"x\""),
        ("Ks 1 nan 1", "a.mtl:2: ks needs a finite number, not \"nan\""),
        ("Kd 1 1", "a.mtl:2: kd needs three numbers, not 2"),
        ("Ns", "a.mtl:2: ns needs a finite number, not \"\""),
        ("Pr inf", "a.mtl:2: pr needs a finite number, not \"inf\""),
    ];
    for (statement, expected) in cases {
        let folder = square("mtllib a.mtl\nusemtl m\nf 1 2 3\n");
        folder.write("a.mtl", format!("newmtl m\n{statement}\n").as_bytes());
        assert_eq!(folder.error(), expected, "{statement}");
    }
}
