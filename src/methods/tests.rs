use super::*;

#[test]
fn every_parameter_is_described_and_takes_its_own_values() {
    for method in METHODS {
        let rows = method.read_parameters();
        for (n, p) in rows.iter().enumerate() {
            let label = format!("{} of {}", p.name, method.name);
            assert!(p.help.ends_with('.') && p.help.len() > 10, "{label}: {:?}", p.help);
            assert!(!p.source.is_empty(), "{label} has no source");
            for value in [p.published, p.author].into_iter().chain(p.sweep.iter().map(|(_, value)| *value)) {
                assert!(p.domain.has(value), "{label}: {value} is outside {}", p.domain);
                assert_eq!(p.parse(&value.to_string()).ok(), Some(value), "{label}");
            }
            assert!(!rows[..n].iter().any(|other| other.name == p.name), "{label} is declared twice");
        }
    }
    let methods_by_parameter = parameters();
    for (parameter, methods) in &methods_by_parameter {
        let mut namesakes = methods_by_parameter.iter().filter(|(other, _)| other.name == parameter.name);
        let has_one_domain = namesakes.all(|(other, _)| other.domain == parameter.domain);
        assert!(has_one_domain, "{} takes other values in another method", parameter.name);
        for method in methods {
            assert!(method.read_parameters().contains(parameter), "{} of {}", parameter.name, method.name);
        }
    }
}

#[test]
fn a_parameter_that_no_chosen_method_has_is_refused() {
    let setup = Setup::new([1, 1]).with(|p: &mut poster::PosterParams| p.edge_retries = 2);
    assert!(choose(&["poster".into(), "ssct".into()], &setup).is_ok());
    let refused = choose(&["ssct".into()], &setup).err().expect("refused").to_string();
    assert!(refused.contains("edge-retries") && refused.contains("poster"), "{refused}");
}
