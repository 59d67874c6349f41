//! Tests `ssct view`, which hands all arguments on to the window's program. The window itself is tested in
//! tests/window.

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// Without the window's program, `ssct view` says how to build it. With one, all arguments are handed on and its status
/// is returned. An argument such as `-h` must not be answered by `ssct` itself.
#[test]
fn the_window_is_a_program_of_its_own_beside_the_command_or_on_the_path() {
    // Hard links must stay on one file system, and a program finds itself by the name of its link.
    let program = Path::new(env!("CARGO_BIN_EXE_ssct"));
    let folder = tempfile::tempdir_in(program.parent().unwrap()).unwrap();
    let own = folder.path().join("ssct");
    std::fs::hard_link(program, &own).unwrap();
    let view = |arguments: &[&str]| {
        let output = Command::new(&own).arg("view").args(arguments).env("PATH", folder.path()).output().unwrap();
        let [printed, errors] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (output.status.code(), printed, errors)
    };
    let (status, printed, message) = view(&["--frames", "1"]);
    assert_eq!((status, printed.as_str(), message.lines().count()), (Some(1), "", 1), "{message}");
    assert!(message.contains("no window") && message.contains("`make view` builds it"), "{message}");
    // All arguments are handed on, also `-h`, which asks for the help.
    let window = folder.path().join("ssct-view");
    symlink("/bin/echo", &window).unwrap();
    assert_eq!(view(&["-h", "--scene", "rooms"]), (Some(0), "-h --scene rooms\n".into(), String::new()));
    std::fs::remove_file(&window).unwrap();
    symlink("/bin/false", &window).unwrap();
    assert_eq!(view(&[]), (Some(1), String::new(), String::new()), "the status is the window's");
    std::fs::remove_file(&window).unwrap();
    symlink(folder.path(), &window).unwrap();
    let (status, _, message) = view(&[]);
    assert!(status == Some(1) && message.contains("cannot be started"), "{message}");
}
