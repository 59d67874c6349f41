//! The `ssct` command. Everything is in the library, under `app`.

fn main() -> std::process::ExitCode {
    ssct_lab::app::run()
}
