//! `ssct render --pixel`: one pixel explained.

use crate::error::{Error, Result};
use crate::stage::{RenderedImage, Shot, Stage, gbuffer};
use crate::study::inspect::Inspection;
use crate::study::pixel::{MethodImages, PixelMethod, PixelReport, explain, verdicts};
use ssct::methods::{MethodInfo, Setup};
use ssct_scenes::{GBufferData, Material, Scene};
use ssct_truth::metrics::verdict::PixelVerdict;
use ssct_truth::reference::surface::World;

/// The method and the scene of a frame.
#[derive(Clone, Copy)]
pub struct FrameSubject<'a> {
    /// The method.
    pub method: &'a MethodInfo,
    /// The setup of the method.
    pub setup: &'a Setup,
    /// The scene.
    pub scene: &'a Scene,
    /// The materials of the view with the global factors.
    pub materials: &'a [Material],
}

/// Parses a pixel such as `480,270`: its column and row, counted from 0 at the top left.
pub fn parse(text: &str) -> std::result::Result<[u32; 2], String> {
    let parts: Vec<_> = text.split(',').map(|part| part.trim().parse::<u32>()).collect();
    match parts[..] {
        [Ok(x), Ok(y)] => Ok([x, y]),
        _ => Err(format!("{text:?} is no pixel; write it as 480,270, counted from 0 at the top left")),
    }
}

/// Refuses a pixel outside of a picture.
pub fn check([x, y]: [u32; 2], [width, height]: [u32; 2]) -> Result<()> {
    if x < width && y < height {
        return Ok(());
    }
    Err(outside([x, y], [width, height]))
}

/// The error for a pixel outside of a picture.
fn outside([x, y]: [u32; 2], [width, height]: [u32; 2]) -> Error {
    let (right, bottom) = (width.saturating_sub(1), height.saturating_sub(1));
    Error::usage(format!(
        "--pixel {x},{y}: the picture has {width}x{height} pixels, from 0,0 at the top left to {right},{bottom}"
    ))
}

/// A frame on the host, and the world that it shows.
pub struct Judge<'a> {
    /// The G-buffer and the rays of the frame.
    inspection: Inspection,
    /// The images that the method made.
    images: MethodImages<'a>,
    /// The scene's triangles, for rays of the references.
    world: World<'a>,
    /// The name of the method and its number of bounces.
    method: PixelMethod<'a>,
}

impl<'a> Judge<'a> {
    /// Reads back the G-buffer of a shot, whose image was rendered with its hits, and prepares the scene for rays.
    pub fn new(
        stage: &mut Stage,
        shot: &Shot,
        rendered: &'a RenderedImage,
        FrameSubject { method, setup, scene, materials }: FrameSubject<'a>,
    ) -> Result<Self> {
        let data = gbuffer::read(&mut stage.context, shot)?;
        let hits = rendered.hits.clone();
        Ok(Self {
            inspection: Inspection::new(data, hits, (method, setup), &rendered.report.recorded),
            images: MethodImages { reflection: &rendered.reflection, composite: &rendered.composite },
            world: World::new(scene, materials),
            method: PixelMethod { name: method.name, bounces: setup.effect().bounces },
        })
    }

    /// Explains why the pixel, given by its column and row, shows what it shows. A pixel outside of the frame is an
    /// error.
    pub fn explain(&self, pixel: [u32; 2]) -> Result<PixelReport> {
        let GBufferData { width, height, .. } = self.inspection.gbuffer;
        explain(&self.inspection, self.images, &self.world, self.method, pixel)
            .ok_or_else(|| outside(pixel, [width, height]))
    }

    /// Says of each pixel whether its reflection is right or, if it is wrong, whether the screen has what belongs
    /// there; rows from the top.
    pub fn verdicts(&self) -> Vec<PixelVerdict> {
        verdicts(&self.inspection, self.images, &self.world, self.method.bounces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_two_whole_numbers_within_the_picture() {
        assert_eq!(parse(" 3, 14"), Ok([3, 14]));
        for wrong in ["3", "3,4,5", "-1,4", "a,b", "1.5,2"] {
            assert!(parse(wrong).unwrap_err().contains(wrong), "{wrong}");
        }
        assert!(check([63, 35], [64, 36]).is_ok());
        let message = check([64, 3], [64, 36]).unwrap_err().to_string();
        assert!(message.contains("64,3") && message.contains("64x36") && message.contains("63,35"), "{message}");
    }
}
