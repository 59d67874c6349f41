//! The thesis's figure 4.7: the cone of one pixel as a triangle with its circles, over the picture that
//! the circles sample.

use super::{COLORS, Svg};
use crate::report::html::data_uri;
use crate::report::images::Rgb;
use glam::Vec2;
use ssct_ground::math::cone::{circles, isosceles_triangle_base};

/// Draws a cone over a picture of the screen, as SVG: a triangle from a pixel (`from`) to its hit, both in texture
/// coordinates, with `count` circles, as published. `theta` is the half angle of the cone in radians.
///
/// Texture coordinates run from 0 to 1 along both sides, so on a wide screen the circles are ellipses.
pub fn cone(from: Vec2, hit: Vec2, theta: f64, count: usize, picture: &Rgb) -> crate::error::Result<String> {
    let screen = Vec2::new(picture.width as f32, picture.height as f32);
    let mut svg = Svg::new(screen + Vec2::new(0.0, 76.0));
    svg.add(format_args!(
        r#"<image href="{}" width="{}" height="{}"/>"#,
        data_uri(picture)?.uri,
        picture.width,
        picture.height
    ));
    let axis = hit - from;
    let (length, along) = (f64::from(axis.length()), axis.normalize_or_zero());
    let half_base = along.perp() * (0.5 * isosceles_triangle_base(length, theta)) as f32;
    let triangle = [from, hit + half_base, hit - half_base, from].map(|p| p * screen);
    svg.polyline(triangle.into_iter(), r##"fill="#fff" fill-opacity="0.12" stroke="#fff" stroke-width="2""##);
    let mut level_texts = Vec::new();
    for (n, circle) in circles(length, theta, count, false).iter().enumerate() {
        let middle = (from + along * circle.distance as f32) * screen;
        let color = COLORS[n % COLORS.len()];
        let attributes = format!(r#"fill="{color}" fill-opacity="0.25" stroke="{color}" stroke-width="2""#);
        svg.circle(middle, screen * circle.radius as f32, &attributes);
        let level = (circle.radius * f64::from(screen.max_element())).log2().max(0.0);
        level_texts.push(format!("{}: level {level:.1}", n + 1));
        // A smaller circle has no room for its number.
        if circle.radius * f64::from(screen.y) > 9.0 {
            let attributes = r##"text-anchor="middle" fill="#fff" font-weight="bold""##;
            svg.text(middle + Vec2::new(0.0, 5.0), 14.0, attributes, &(n + 1).to_string());
        }
    }
    for (point, fill) in [(from, "#111"), (hit, "#fff")] {
        let attributes = format!(r##"fill="{fill}" stroke="#fff" stroke-width="1.5""##);
        svg.circle(point * screen, Vec2::splat(4.0), &attributes);
    }
    let angle_text = format!("Half angle {theta:.4} rad; circles from the hit (white) to the pixel (dark), by Alg. 5:");
    svg.text(Vec2::new(12.0, screen.y + 22.0), 13.0, "", &angle_text);
    for (n, line) in level_texts.chunks(8).enumerate() {
        svg.text(Vec2::new(12.0, screen.y + 42.0 + 18.0 * n as f32), 13.0, "", &line.join("   "));
    }
    Ok(svg.finish())
}
