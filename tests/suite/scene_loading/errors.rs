//! Tests every error of OBJ files: each is one sentence with the file and, where there is one, the line.

use super::*;

/// Each faulty line after the square, whose own lines end at line 8, is refused with its sentence. Blank and joined
/// lines make the count go wrong.
#[test]
fn errors_name_file_line_and_cause() {
    let cases = [
        ("v nan 0 0\n", "a.obj:9: the position of a vertex is not a number: \"nan\" is not finite"),
        ("v 0 -inf 0\n", "a.obj:9: the position of a vertex is not a number: \"-inf\" is not finite"),
        ("v 0 -1.#IND 0\n", "a.obj:9: the position of a vertex is not a number: \"-1.#IND\" is not finite"),
        ("\nv 0 1e99 0\n", "a.obj:10: the position of a vertex is not a number: \"1e99\" is not finite"),
        ("v 1 2\n", "a.obj:9: a vertex ends after 2 numbers; it needs 3"),
        ("vt\n", "a.obj:9: a texture coordinate ends after 0 numbers; it needs 1"),
        ("v 1 2 x\n", "a.obj:9: \"x\" in a vertex is not a number"),
        ("f 1 2 5\n", "a.obj:9: a face refers to vertex 5, but there are 4"),
        ("f 1 2 3\nf 1 2 -5\n", "a.obj:10: a face refers to vertex -5, but there are 4"),
        ("f 1 2 0\n", "a.obj:9: a face refers to vertex 0, but there are 4"),
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

/// A face of 1025 corners is refused. Splitting a face into triangles takes the square of its corners.
#[test]
fn faces_of_too_many_corners_are_refused() {
    let face = format!("f{}\n", " 1".repeat(1025));
    assert_eq!(square(&face).error(), "a.obj:9: a face has 1025 corners, more than 1024");
}

/// A missing file, an empty one, and one of 3 GiB are refused with a sentence each, the last one before it is read.
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

/// Folders and devices are refused as OBJ files. Reading a device such as `/dev/zero` would never end.
#[test]
fn only_regular_files_are_read() {
    let folder = square("f 1 2 3\n");
    std::fs::create_dir(folder.path("b.obj")).unwrap();
    let error = folder.load("b.obj", &LEFT).unwrap_err().to_string();
    assert_eq!(folder.without_folder(&error), "b.obj: is no file; a file is read from a regular file alone");
    for device in ["/dev/zero", "/dev/full"].map(std::path::Path::new) {
        if device.exists() {
            let error = obj::load(&[ObjFile::from(device)], &LEFT).unwrap_err().to_string();
            assert!(error.ends_with("is no file; a file is read from a regular file alone"), "{error}");
        }
    }
}

/// A scale that is no positive number, and a scene without files, are mistakes of usage, which have another exit status
/// than mistakes in a file.
#[test]
fn wrong_arguments_are_usage_errors() {
    let folder = square("f 1 2 3\n");
    for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = folder.load("a.obj", &ObjOptions { load: scaled(scale), ..LEFT }).unwrap_err();
        assert!(matches!(error, ssct_ground::Error::Usage(_)), "{error}");
        assert_eq!(error.to_string(), format!("the scale must be a positive number, not {scale}"));
    }
    assert_eq!(obj::load(&[], &LEFT).unwrap_err().to_string(), "a scene needs at least one OBJ file");
}
