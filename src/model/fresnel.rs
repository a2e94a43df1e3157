//! Reflection by the faces of glass.

/// Reflection of a triangle's surface, which takes light from its beam: Fresnel's formulas for unpolarised
/// light, at the angle between the straight ray and the triangle's plane. The colour `c` of a hit is
/// multiplied by the transmitted share. Refractive indices are 1 to 3; 1 reflects nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Fresnel {
    /// No reflection: the table of transfers alone.
    #[default]
    None,
    /// A face between air and a body: 4 % head-on at an index of 1.5.
    Face {
        /// Index of refraction of the body.
        ior: f32,
    },
    /// A thin pane, with both faces and all reflections between them: 7.7 % head-on at an index of 1.5.
    Pane {
        /// Index of refraction of the pane.
        ior: f32,
    },
}

impl Fresnel {
    /// The refractive index, 1 without reflection.
    pub(crate) fn ior(self) -> f32 {
        match self {
            Self::None => 1.0,
            Self::Face { ior } | Self::Pane { ior } => ior,
        }
    }

    /// The refractive index of a face, or minus that of a pane; 0 for no reflection.
    pub fn index(self) -> f32 {
        match self {
            Self::Face { ior } if ior > 1.0 => ior,
            Self::Pane { ior } if ior > 1.0 => -ior,
            _ => 0.0,
        }
    }
}
