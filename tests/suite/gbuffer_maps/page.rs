//! Tests that the page on maps, docs/gbuffer-maps.md, has every key of every section, and no other.

use super::errors::{folder, map_error};
use crate::common::repository;

/// For each section of a map, the table on the page has the keys that the error about an unknown key lists. A new key
/// is easily left out of the page.
#[test]
fn the_page_has_every_key() {
    let page = std::fs::read_to_string(repository().join("docs/gbuffer-maps.md")).unwrap();
    let folder = folder();
    let metallic = "[metallic]\nvalue = 1\n[base-color]\nvalue = 1\n[f0]\nvalue = 0.04";
    for (section, change) in [
        ("[conventions]", vec![]),
        ("[camera]", vec![]),
        ("[depth]", vec![]),
        ("[normal]", vec![]),
        ("[roughness]", vec![]),
        ("[reflectivity]", vec![]),
        ("[metallic]", vec![("[reflectivity]\nvalue = 0.5", metallic)]),
        ("[base-color]", vec![("[reflectivity]\nvalue = 0.5", metallic)]),
        ("[f0]", vec![("[reflectivity]\nvalue = 0.5", metallic)]),
        (
            "[position]",
            vec![("[reflectivity]", "[position]\nspace = \"view\"\nchannels = [\"R\", \"G\", \"B\"]\n[reflectivity]")],
        ),
        ("[sky]", vec![("[reflectivity]", "[sky]\nchannel = \"Z\"\n[reflectivity]")]),
        ("[[color]]", vec![]),
    ] {
        let unknown = format!("{section}\nunknown-key = 1");
        let text = map_error(&folder, &[&change[..], &[(section, &unknown)]].concat());
        let (_, keys) = text.split_once("there is no key \"unknown-key\" here; there are ").expect(&text);
        let heading = format!("### `{section}`");
        let (_, section_text) = page.split_once(&format!("{heading}\n")).unwrap_or_else(|| panic!("no {heading}"));
        let section_text = section_text.split("\n#").next().unwrap();
        // The rows of the table of keys, which begin with a key; values in other tables are in quotation marks.
        let rows = section_text.lines().filter(|l| l.starts_with("| `") && !l.starts_with("| `\""));
        let mut documented: Vec<&str> =
            rows.flat_map(|line| line[1..].split('|').next().unwrap().split('`').skip(1).step_by(2)).collect();
        let mut keys: Vec<&str> = keys.split(", ").collect();
        documented.sort_unstable();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(documented, keys, "{section}");
    }
}
