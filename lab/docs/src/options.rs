//! Makes the page of the parameters of all methods (`docs/options.md`) from the tables in which the methods declare
//! them.

use ssct::methods::exclusions::EXCLUSIONS;
use ssct::methods::{METHODS, parameters};

/// The text above the rows of the first table.
const HEAD: &str = "# Parameters of the methods\n\nEvery parameter is an option of the commands that run methods, such as `render`, \
    `error` and `view` (`--cone-samples 3`), a row of the window's panel, and a value in the `setup` of every record \
    (`cone_samples`). A method that is not named does not read it. A switch takes `on` or `off` (`--split on`, `--fade off`), and \
    alone it means on (`--split`). `--captures` of `gbuffer reflect` takes a folder instead \
    ([what is in it](definitions.md#captures)). `--preset` chooses between the published values and those of the author's own \
    program. This page is made from the tables in the code (`make docs`).\n\n\
    | parameter | methods | what it does | values | published | author | source |\n|---|---|---|---|---|---|---|\n";

/// Returns the text of `docs/options.md`: a table of all parameters, and a table of the requests that are refused.
pub(crate) fn page() -> String {
    let screen_space: Vec<_> = METHODS.iter().filter(|m| m.is_screen_space()).map(|m| m.name).collect();
    let mut page = HEAD.to_owned();
    for (parameter, methods) in parameters() {
        let names: Vec<_> = methods.iter().map(|m| m.name).collect();
        let names = match names.len() {
            n if n == METHODS.len() => "every method".to_owned(),
            _ if names == screen_space => "every screen-space method".to_owned(),
            _ => names.join(", "),
        };
        let unit = if parameter.unit.is_empty() { String::new() } else { format!(" ({})", parameter.unit) };
        let (name, help, domain, source) = (parameter.typed_name(), parameter.help, parameter.domain, parameter.source);
        let (published, author) = (parameter.published, parameter.author);
        page += &format!("| `{name}` | {names} | {help} | {domain}{unit} | {published} | {author} | {source} |\n");
    }
    page += "\n## What is refused\n\nAn effect refuses these requests with a sentence that names what was asked for.\n\n\
             | parameter | is refused |\n|---|---|\n";
    for exclusion in EXCLUSIONS {
        page += &format!("| `{}` | {} |\n", exclusion.parameter.replace('_', "-"), exclusion.refused);
    }
    page
}
