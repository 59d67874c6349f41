//! placeholder
use super::Scene;
pub fn names() -> &'static [&'static str] {
    &[]
}
pub fn scene(_n: &str) -> Option<Scene> {
    None
}
