//! Says in sentences why a pixel has its colour.

use super::{MethodEnd, OracleEnd, PixelReport, WorldEnd};
use ssct_truth::metrics::hits::HitVerdict;
use ssct_truth::metrics::verdict::{PixelVerdict, WRONG};
use ssct_truth::metrics::world::is_same_place;
use ssct_truth::reference::MissReason;
use ssct_truth::reference::pixel::{EstimatedColor, UnseenReason};

/// Returns the sentences that explain a pixel. `is_sky_surface` says that the pixel's mesh shows the environment, and
/// `traces_lobes` that the method's ray of a rough pixel is not the mirror ray.
pub(super) fn sentences(report: &PixelReport, is_sky_surface: bool, traces_lobes: bool) -> Vec<String> {
    if !report.surface.reflects {
        return vec![not_reflecting_sentence(report, is_sky_surface)];
    }
    let is_rough = report.surface.roughness > 0.0;
    // The oracle and the world follow the mirror ray, so that another ray cannot be compared with theirs.
    let is_mirror_ray = !(is_rough && traces_lobes);
    let mut all = vec![verdict_sentence(report)];
    all.extend(report.world_end.as_ref().map(world_sentence));
    if let (Some(method_end), Some(oracle_end), true) = (&report.method_end, &report.oracle_end, is_mirror_ray) {
        all.extend(method_sentence(method_end, oracle_end, report.world_end.as_ref()));
    }
    // If the fade alone is to blame, the sentence of the verdict has already said how much colour it leaves.
    all.extend(fade_sentence(report).filter(|_| !is_wrong_by_fade_alone(report)));
    all.extend(if is_rough { None } else { color_sentence(report) });
    if is_rough {
        let about_method = if traces_lobes { "; the method's own ray is another one of the lobe" } else { "" };
        all.push(format!(
            "The surface is rough: colours are means over a lobe, and ends are those of its mirror ray{about_method}."
        ));
    }
    all
}

/// Says in a sentence why a pixel does not reflect.
fn not_reflecting_sentence(report: &PixelReport, is_sky_surface: bool) -> String {
    let surface = &report.surface;
    match &surface.mesh {
        None => "The pixel does not reflect: it shows the sky.".to_owned(),
        Some(mesh) if is_sky_surface => format!("The pixel does not reflect: {mesh} shows the environment."),
        Some(mesh) => {
            format!("The pixel does not reflect: the reflectivity of {mesh} is {} there.", surface.reflectivity)
        }
    }
}

/// Says in a sentence whether the reflection is right, and by how much it differs from the world reference.
fn verdict_sentence(report: &PixelReport) -> String {
    let off = report.colors.world.as_ref().map_or(0.0, |world| 100.0 * world.difference);
    let by = format!(
        "it differs from the world's by {off:.0} % of white (more than {:.0} % beyond what chance explains is wrong)",
        100.0 * WRONG
    );
    if is_wrong_by_fade_alone(report) {
        let left = 100.0 * report.colors.fade;
        return format!(
            "The reflection is wrong by the fade at the picture's border alone, which leaves {left:.0} % of its colour: {by}."
        );
    }
    match report.verdict {
        PixelVerdict::Right => format!("The reflection is right: {by}."),
        PixelVerdict::WrongByScreen => {
            format!("The reflection is wrong, though the screen has its colour: {by}.")
        }
        PixelVerdict::WrongByWorld => {
            format!("The reflection is wrong, and the screen does not have its colour: {by}.")
        }
        PixelVerdict::NotReflecting => "The pixel does not reflect.".to_owned(),
    }
}

/// Says in a sentence where the mirror ray ends in the world, and what hides this place from the screen, if it is
/// hidden.
fn world_sentence(end: &WorldEnd) -> String {
    let Some(mesh) = &end.mesh else { return "In the world the ray meets nothing: it ends in the sky.".to_owned() };
    let length = end.length_m.unwrap_or_default();
    let met = format!("In the world the ray meets {mesh} after {length:.2} m, which");
    let place = end.pixel.map(|[x, y]| format!(", at {x:.1}, {y:.1}")).unwrap_or_default();
    match (end.shown, end.hidden) {
        (true, _) | (_, None) => format!("{met} the screen shows{place}."),
        (false, Some(hidden)) => {
            let by = match (&end.hidden_by, end.shown_view_z_m, end.view_z_m) {
                (Some(by), Some(before), Some(z)) => {
                    let by = if by == mesh { "another part of it" } else { by };
                    format!(" {by}, at {before:.2} m of view depth against {z:.2} m")
                }
                (None, Some(shown), Some(z)) if shown > z => {
                    format!(
                        ": the picture shows what lies at {shown:.2} m of view depth there, and the place lies at {z:.2} m"
                    )
                }
                (None, Some(shown), Some(z)) => format!(", at {shown:.2} m of view depth against {z:.2} m"),
                _ => String::new(),
            };
            format!("{met} {hidden}{by}{place}.")
        }
    }
}

/// Says why the screen does not show a place in the world, as the end of a sentence about the place. `is_before_near`
/// says that the place lies before the near plane.
pub(super) fn unseen_text(unseen: &UnseenReason, is_before_near: bool) -> &'static str {
    match unseen {
        UnseenReason::BehindEye => "lies behind the eye",
        UnseenReason::OffScreen => "lies beside the picture",
        UnseenReason::Hidden { by: Some(_), .. } => "is hidden behind",
        UnseenReason::Hidden { by: None, .. } => "is hidden behind what the picture shows",
        UnseenReason::NotDrawn { .. } if is_before_near => "lies before the near plane",
        UnseenReason::NotDrawn { .. } => "the picture does not draw",
    }
}

/// Says in a sentence whether the method's ray ends on the screen where the oracle's ray does, and whether it ends
/// where the world's does. `None` for a ray that went on beyond the screen.
fn method_sentence(method: &MethodEnd, oracle: &OracleEnd, world: Option<&WorldEnd>) -> Option<String> {
    // The screen's oracle says nothing about rays that went beyond the screen.
    if method.place_m.is_some() && !method.hits_screen {
        return None;
    }
    let method_pixel = method.pixel.map(|p| p.map(f64::from));
    let text_of = |[x, y]: [f64; 2]| format!("{x:.1}, {y:.1}");
    Some(match HitVerdict::compare(method_pixel, oracle.pixel) {
        HitVerdict::Agrees => {
            let shown_world_pixel = world.filter(|end| end.shown).and_then(|end| end.pixel);
            let is_as_in_world = match (method_pixel, shown_world_pixel) {
                (Some(a), Some(b)) => is_same_place(a, b),
                (a, b) => a.is_none() && b.is_none(),
            };
            let ends =
                if method_pixel.is_some() { "ends where the oracle's does" } else { "hits nothing, as by the oracle" };
            let rest = match method_pixel.zip(shown_world_pixel) {
                _ if is_as_in_world => "",
                Some(_) => {
                    "; the place where it ends in the world is on the screen, too, but the ray meets something before it"
                }
                None => "; in the world it ends elsewhere",
            };
            format!("On the screen the method's ray {ends}{rest}.")
        }
        HitVerdict::False => {
            let pixel = method_pixel.map(text_of).unwrap_or_default();
            format!("The method takes the ray for a hit at {pixel}; by the oracle it {}.", oracle.end)
        }
        HitVerdict::Missed => {
            let pixel = oracle.pixel.map(text_of).unwrap_or_default();
            format!("By the oracle the ray hits {pixel}; the method's ray {}.", method.end)
        }
        HitVerdict::Displaced => {
            let [hit, oracle_hit] = [method_pixel, oracle.pixel].map(|p| p.map(text_of).unwrap_or_default());
            format!("The method's ray hits {hit}, and the oracle's {oracle_hit}.")
        }
    })
}

/// Says in a sentence why the colour of a mirror's pixel is wrong, although its ray ends right and the reflection does
/// not fade; `None` in any other case.
fn color_sentence(report: &PixelReport) -> Option<String> {
    let (method, oracle) = (report.method_end.as_ref()?, report.oracle_end.as_ref()?);
    let world = report.world_end.as_ref()?;
    let method_pixel = method.pixel.map(|p| p.map(f64::from));
    let ends_right = HitVerdict::compare(method_pixel, oracle.pixel) == HitVerdict::Agrees
        && method_pixel.zip(world.pixel).is_some_and(|(a, b)| world.shown && is_same_place(a, b));
    let is_wrong = matches!(report.verdict, PixelVerdict::WrongByScreen | PixelVerdict::WrongByWorld);
    (is_wrong && ends_right && fade_sentence(report).is_none()).then(|| {
        "The ray ends right, and its colour differs: the references are means over the area of the pixel, and in a window they \
         show the environment along the ray."
            .to_owned()
    })
}

/// Says in a sentence what share of the reflection the fade leaves; `None` if it leaves all, or if the ray does not hit
/// the screen.
fn fade_sentence(report: &PixelReport) -> Option<String> {
    let fade = report.colors.fade;
    let is_hit = report.method_end.as_ref().is_none_or(|end| end.hits_screen);
    // A fade is stored as a 16-bit float, so that a fade of 1 may be read as a little less.
    let is_partial = is_hit && (0.0..0.995).contains(&fade);
    is_partial.then(|| format!("The fade at the picture's border leaves {:.0} % of the reflection.", 100.0 * fade))
}

/// Whether the reflection is wrong, and would be right without its fade.
fn is_wrong_by_fade_alone(report: &PixelReport) -> bool {
    let colors = &report.colors;
    let is_wrong = matches!(report.verdict, PixelVerdict::WrongByScreen | PixelVerdict::WrongByWorld);
    let Some((screen, world)) = colors.screen.as_ref().zip(colors.world.as_ref()) else { return false };
    let [screen, world] = [screen, world].map(|reference| EstimatedColor {
        color: reference.color.into(),
        standard_error: reference.standard_error.into(),
    });
    let without_fade = PixelVerdict::judge(colors.reflection.into(), &screen, &world);
    is_wrong && fade_sentence(report).is_some() && without_fade == PixelVerdict::Right
}

/// Says in words how a ray ends that hits nothing on the screen. `behind` says that it left behind a surface.
pub(super) fn miss_text(reason: MissReason, behind: bool) -> &'static str {
    match (reason, behind) {
        (MissReason::NoRay, _) => "has no ray",
        (MissReason::LeftScreen, false) => "leaves the picture",
        (MissReason::LeftScreen, true) => "leaves the picture behind a surface",
        (MissReason::Near, false) => "passes the near plane",
        (MissReason::Near, true) => "passes the near plane behind a surface",
        (MissReason::Far, false) => "passes the far plane",
        (MissReason::Far, true) => "passes the far plane behind a surface",
    }
}
