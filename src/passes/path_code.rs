//! Codes that say how rays ended, as images of [`Hits`](super::Hits) hold them.

use ssct_ground::math::constants;

/// How a ray ended: the fourth channel of [`Hits`](super::Hits).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathCode {
    /// The pixel does not reflect.
    None = constants::PATH_NONE as isize,
    /// The Hi-Z traversal found a hit.
    HiZ = constants::PATH_HI_Z as isize,
    /// A linear march found a hit: that of `ssct` for rays towards the camera, or that of a method that only marches.
    Linear = constants::PATH_LINEAR as isize,
    /// The Hi-Z traversal left the screen.
    Miss = constants::PATH_MISS as isize,
    /// A linear march found nothing.
    LinearMiss = constants::PATH_LINEAR_MISS as isize,
    /// The ray ran out of iterations; the thesis takes this end for a hit.
    Exhausted = constants::PATH_EXHAUSTED as isize,
    /// The ray goes towards the camera, and the method traces no such rays.
    Untraced = constants::PATH_UNTRACED as isize,
    /// `unified`: the ray ran out of steps. Such an end cannot happen and is never a hit, but it is counted.
    Unfinished = constants::PATH_UNFINISHED as isize,
    /// `unified`: the ray left by a side of the screen.
    MissScreen = constants::PATH_MISS_SCREEN as isize,
    /// `unified`: the ray went behind the near plane.
    MissNear = constants::PATH_MISS_NEAR as isize,
    /// `unified`: the ray went beyond the far plane.
    MissSky = constants::PATH_MISS_SKY as isize,
    /// `unified`: the ray left the frustum behind geometry.
    MissBehind = constants::PATH_MISS_BEHIND as isize,
    /// With captures or triangles: the ray ended in the sky.
    Sky = constants::PATH_SKY as isize,
    /// With captures: the ray went where no image sees it.
    Unknown = constants::PATH_UNKNOWN as isize,
    /// `dda`: the ray ran out of steps, and is taken for a miss.
    LinearExhausted = constants::PATH_LINEAR_EXHAUSTED as isize,
    /// With triangles: the ray hit a triangle.
    Triangle = constants::PATH_TRIANGLE as isize,
    /// With captures: the ray hit something in a capture, whose number [`PathCode::capture`] returns.
    Capture = constants::PATH_CAPTURE as isize,
}

impl PathCode {
    /// Returns the code that a value of the fourth channel stands for; `None` for a value that is no code.
    pub fn from_channel(value: f32) -> Option<Self> {
        const CODES: [PathCode; 16] = [
            PathCode::None,
            PathCode::HiZ,
            PathCode::Linear,
            PathCode::Miss,
            PathCode::LinearMiss,
            PathCode::Exhausted,
            PathCode::Untraced,
            PathCode::Unfinished,
            PathCode::MissScreen,
            PathCode::MissNear,
            PathCode::MissSky,
            PathCode::MissBehind,
            PathCode::Sky,
            PathCode::Unknown,
            PathCode::LinearExhausted,
            PathCode::Triangle,
        ];
        if Self::capture(value).is_some() {
            return Some(Self::Capture);
        }
        CODES.into_iter().find(|c| *c as u8 as f32 == value)
    }

    /// Returns the number of the capture in which a ray hit, by the value of the fourth channel; `None` for other ends.
    pub fn capture(value: f32) -> Option<usize> {
        let mut slots = 0..constants::CAPTURE_SLOTS;
        slots.find(|slot| value == (constants::PATH_CAPTURE + slot) as f32).map(|slot| slot as usize)
    }

    /// Returns the end of a sentence whose subject is a ray with this code.
    pub fn words(self) -> &'static str {
        match self {
            Self::None => "does not exist",
            Self::HiZ => "hits by the Hi-Z traversal",
            Self::Linear => "hits by a linear march",
            Self::Miss => "left the picture in the Hi-Z traversal",
            Self::LinearMiss => "found nothing in a linear march",
            Self::Exhausted => "ran out of iterations, and is taken for a hit",
            Self::Untraced => "runs towards the camera, and was not traced",
            Self::Unfinished => "ran out of steps",
            Self::MissScreen => "left the picture by a side",
            Self::MissNear => "went behind the near plane",
            Self::MissSky => "went beyond the far plane",
            Self::MissBehind => "passed behind a surface",
            Self::Sky => "ended in the sky",
            Self::Unknown => "went where no capture sees it",
            Self::LinearExhausted => "ran out of steps, and is taken for a miss",
            Self::Triangle => "hits a triangle of the scene",
            Self::Capture => "hits in a capture",
        }
    }

    /// Whether the method takes the ray for a hit on the screen.
    pub fn is_hit(self) -> bool {
        matches!(self, Self::HiZ | Self::Linear | Self::Exhausted)
    }

    /// Whether the ray ran out of steps before it ended.
    pub fn is_exhausted(self) -> bool {
        matches!(self, Self::Exhausted | Self::Unfinished | Self::LinearExhausted)
    }

    /// Whether the ray was traced by the Hi-Z traversal (`true`) or a linear march (`false`); `None` if not traced.
    pub fn by_hi_z(self) -> Option<bool> {
        match self {
            Self::HiZ | Self::Miss | Self::Exhausted | Self::Unfinished => Some(true),
            Self::MissScreen | Self::MissNear | Self::MissSky | Self::MissBehind => Some(true),
            Self::Sky | Self::Unknown | Self::Triangle | Self::Capture => Some(true),
            Self::Linear | Self::LinearMiss | Self::LinearExhausted => Some(false),
            Self::None | Self::Untraced => None,
        }
    }
}
