//! Composes figures from renders.

use super::plate::FinishedFigure;
use super::renderer::FigureRenderer;
use crate::error::Error;
use crate::report::diagrams::{self, Fetches};
use crate::report::gbuffer_pictures;
use crate::report::images::{Rgb, display};
use crate::report::sheet::{Part, difference, enlarged, framed, sheet};
use crate::stage::Intermediates;
use crate::study::twin::hi_z_constants;
use glam::{Vec2, Vec3};
use ssct::gpu::Pixels;
use ssct::methods::Setup;
use ssct::methods::thesis::{self, HiZParams};
use ssct::passes::{Content, PathCode};
use ssct_scenes::Camera;
use ssct_truth::reference::Level;
use ssct_truth::reference::hi_z::MinMax;
use ssct_truth::reference::hi_z_ray_trace::{End, HiZTrace, reflection_ray, trace};

/// Places the renders side by side, two in a row.
pub fn place_side_by_side(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    Ok(FinishedFigure::Picture(sheet(&rows(render_all(renderer, arguments)?))))
}

/// Renders a picture for each element of `arguments`.
fn render_all(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<Vec<Rgb>> {
    Ok(arguments.iter().map(|a| renderer.render_picture(a)).collect::<crate::error::Result<_>>()?)
}

/// Arranges pictures in rows of two; the last row may have one alone.
fn rows(pictures: Vec<Rgb>) -> Vec<Vec<Rgb>> {
    pictures.chunks(2).map(<[Rgb]>::to_vec).collect()
}

/// Figure 5.3: the enlarged part of the left wall.
const WALL: Part = [0.02, 0.36, 0.25, 0.25];

/// The factor by which parts of pictures are enlarged.
const MAGNIFICATION: u32 = 4;

/// Two renders, each with the enlarged left wall below it.
pub fn corridor_with_wall(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let pictures = render_all(renderer, arguments)?;
    let above = pictures.iter().map(|p| framed(p, WALL)).collect();
    let below = pictures.iter().map(|p| enlarged(p, WALL, MAGNIFICATION)).collect();
    Ok(FinishedFigure::Picture(sheet(&[above, below])))
}

/// The factor by which the difference image of figure 5.5 is amplified.
const EXAGGERATION: u8 = 2;

/// Two renders with their difference below.
pub fn with_difference(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let pictures = render_all(renderer, arguments)?;
    let [a, b] = &pictures[..] else { anyhow::bail!("a difference needs two pictures") };
    let difference = difference(a, b, EXAGGERATION)?;
    Ok(FinishedFigure::Picture(sheet(&[pictures, vec![difference]])))
}

/// Schmidt's figure 39: the parts of the last render that are enlarged.
const DETAILS: [Part; 2] = [[0.1, 0.6, 0.25, 0.25], [0.55, 0.6, 0.25, 0.25]];

/// Places the renders in rows of two. Parts of the last render get a frame, and are enlarged in a row below.
pub fn with_details(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let mut pictures = render_all(renderer, arguments)?;
    let details: Vec<Rgb> =
        pictures.last().map(|p| DETAILS.map(|d| enlarged(p, d, MAGNIFICATION)).to_vec()).unwrap_or_default();
    if let Some(last) = pictures.last_mut() {
        *last = DETAILS.iter().fold(last.clone(), |p, d| framed(&p, *d));
    }
    let mut rows = rows(pictures);
    rows.push(details);
    Ok(FinishedFigure::Picture(sheet(&rows)))
}

/// Makes the first render. Returns its intermediate images and its camera.
fn render_first(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<(Intermediates, Camera)> {
    let Some(first) = arguments.first() else { anyhow::bail!("the figure has no render") };
    Ok(renderer.render_intermediates(first)?)
}

/// Returns the pixels of the intermediate image whose stem is `stem`.
fn find_image<'a>(images: &'a Intermediates, stem: &str) -> Result<&'a Pixels, Error> {
    let found = images.iter().find(|(name, ..)| name == stem).map(|(.., pixels)| pixels);
    found.ok_or_else(|| Error::usage(format!("the frame has no {stem}")))
}

/// Reads the Hi-Z chain of a frame from its intermediate images, with the finest level first.
fn read_hi_z(images: &Intermediates) -> Vec<Level<MinMax>> {
    let levels = images.iter().filter(|(_, content, _)| *content == Content::StandardDepth);
    levels
        .map(|(.., p)| Level { width: p.width, height: p.height, texels: p.texels().map(MinMax::from_texel).collect() })
        .collect()
}

/// The minima alone of a Hi-Z chain.
fn minima(chain: &[Level<MinMax>]) -> Vec<Level<f32>> {
    let level_minima = |l: &Level<MinMax>| Level {
        width: l.width,
        height: l.height,
        texels: l.texels.iter().map(|t| t.min).collect(),
    };
    chain.iter().map(level_minima).collect()
}

/// Figure 4.1: the Hi-Z chain of a frame with even sides.
pub fn even_chain(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let (images, _) = render_first(renderer, arguments)?;
    Ok(FinishedFigure::Drawing(diagrams::chain(&minima(&read_hi_z(&images)), Fetches::Neighbours)))
}

/// Figure 4.2: a chain of minima over a frame with odd sides, each minimum of two by two texels.
pub fn undersized_chain(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let (images, _) = render_first(renderer, arguments)?;
    let chain = minima(&read_hi_z(&images));
    let Some(depth) = chain.first() else { anyhow::bail!("the frame has no Hi-Z chain") };
    Ok(FinishedFigure::Drawing(diagrams::chain(&diagrams::undersized(depth), Fetches::Neighbours)))
}

/// Figure 4.3: the Hi-Z chain of a frame with odd sides, by Eq. 4.1.
pub fn odd_chain(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let (images, _) = render_first(renderer, arguments)?;
    Ok(FinishedFigure::Drawing(diagrams::chain(&minima(&read_hi_z(&images)), Fetches::Offset)))
}

/// The numbers of iterations that can still be distinguished in figure 4.6.
const READABLE: std::ops::RangeInclusive<usize> = 10..=26;

/// Figure 4.6: draws the ray that climbs to the highest level, of all rays that hit after a readable number of
/// iterations. Of several such rays, it is the one that turns most often from going up to going down or back.
pub fn ray(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let (images, camera) = render_first(renderer, arguments)?;
    let chain = read_hi_z(&images);
    let normals = find_image(&images, "normal")?;
    let extent = [normals.width, normals.height];
    let published: HiZParams = Setup::new(extent).parameters();
    let fade = true;
    let numbers = published.fill(thesis::block(&camera, extent, chain.len() as u32, fade));
    let constants = hi_z_constants(&numbers);
    let size = Vec2::new(extent[0] as f32, extent[1] as f32);
    // Traces the reflected ray of pixel n, counted in rows. `None` without a normal, and for a ray towards the camera.
    // `p_ss` and `v_ss` are the ray's start and direction on the screen, as the thesis calls them.
    let trace_pixel = |n: usize| -> Option<HiZTrace> {
        let (x, y) = (n as u32 % extent[0], n as u32 / extent[0]);
        let normal = Vec3::from_slice(normals.texel(x, y)).try_normalize()?;
        let z = chain.first()?.at_clamped(x, y).min;
        let p_ss = ((Vec2::new(x as f32, y as f32) + 0.5) / size).extend(z);
        let v_ss = reflection_ray(&camera, p_ss, normal, numbers.reflection_offset);
        (v_ss.z > numbers.view_direction_epsilon).then(|| trace(&chain, p_ss, v_ss, &constants))
    };
    let is_readable = |t: &HiZTrace| t.end == End::Hit && READABLE.contains(&t.steps.len());
    let turns = |t: &HiZTrace| t.steps.windows(2).filter(|s| s[0].crossed != s[1].crossed).count();
    let highest_level = |t: &HiZTrace| t.steps.iter().map(|s| s.level).max();
    let pixels = 0..(extent[0] * extent[1]) as usize;
    let best = pixels.filter_map(trace_pixel).filter(is_readable).max_by_key(|t| (highest_level(t), turns(t)));
    let Some(best) = best else { anyhow::bail!("no ray of this frame takes a readable number of iterations") };
    Ok(FinishedFigure::Drawing(diagrams::ray(&best, &chain)))
}

/// The number of circles in the cone of figure 4.7.
const CIRCLES: usize = 7;

/// Figure 4.7: draws the cone of one pixel with a Hi-Z hit. The pixel is chosen so that its cone is about two fifths of
/// the screen long and lies near the middle of the screen.
pub fn cone(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let (images, _) = render_first(renderer, arguments)?;
    let (hits, lit) = (find_image(&images, "hits")?, find_image(&images, "color-0")?);
    let options = super::renderer::parse(&arguments[0])?;
    let roughness = f64::from(options.common.place.roughness.first().copied().unwrap_or(0.0));
    let size = Vec2::new(hits.width as f32, hits.height as f32);
    // The place of pixel n and that of its hit, as shares of the screen's sides; `None` without a Hi-Z hit.
    let cone_ends = |(n, texel): (usize, &[f32])| {
        let pixel = Vec2::new((n as u32 % hits.width) as f32, (n as u32 / hits.width) as f32);
        let (from, hit) = ((pixel + 0.5) / size, Vec2::new(texel[0], texel[1]));
        (PathCode::from_channel(texel[3]) == Some(PathCode::HiZ)).then_some((from, hit))
    };
    // How far a cone is from the wanted length, 0.4, and, at half weight, from the middle of the screen.
    let deviation = |(from, hit): &(Vec2, Vec2)| {
        (from.distance(*hit) - 0.4).abs() + 0.5 * from.midpoint(*hit).distance(Vec2::splat(0.5))
    };
    let best = hits.texels().enumerate().filter_map(cone_ends).min_by(|a, b| deviation(a).total_cmp(&deviation(b)));
    let Some((from, hit)) = best else { anyhow::bail!("no ray of this frame hits") };
    // Eq. 4.5, with the half angle of the lobe as this project defines it: half the roughness.
    let theta = 0.5 * roughness;
    Ok(FinishedFigure::Drawing(diagrams::cone(from, hit, theta, CIRCLES, &display(lit))?))
}

/// Schmidt's figure 27: the G-buffer of a frame.
pub fn gbuffer(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let (images, camera) = render_first(renderer, arguments)?;
    Ok(FinishedFigure::Picture(sheet(&gbuffer_pictures::rows(&images, &camera)?)))
}

/// Schmidt's figure 51: for each render, a picture of the reflectivity of its pixels.
pub fn reflectivity(renderer: &mut FigureRenderer, arguments: &[String]) -> anyhow::Result<FinishedFigure> {
    let reflectivity_picture = |a: &String| -> anyhow::Result<Rgb> {
        let (images, _) = renderer.render_intermediates(a)?;
        Ok(gbuffer_pictures::reflectivity(find_image(&images, "material")?))
    };
    let pictures = arguments.iter().map(reflectivity_picture).collect::<anyhow::Result<Vec<_>>>()?;
    Ok(FinishedFigure::Picture(sheet(&rows(pictures))))
}
