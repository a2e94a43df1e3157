//! The picture's and the masks' kernels by name.
use crate::{
    frame::Kernels,
    gpu::{Kernel, KernelDesc, KernelError},
    stage::{air, features::Features, mask, shade},
};

/// Kernels that are specialised to the features of a picture.
#[cfg_attr(not(feature = "picture"), allow(dead_code, reason = "some are the picture's"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Variant {
    AirScatter,
    ShadeClip,
    ShadeSeen,
    ShadeLayered,
    ShadeLayers,
    ShadeSurfaces,
    ShadePanes,
    ShadeCasters,
    LightPoints,
    ShadeComposite,
    MaskSurfaces,
    HalfMaskSurfaces,
    HostSurfaces,
    HalfHostSurfaces,
    MaskLookUp,
    MaskBlur,
    MaskEnlarge,
}

impl Variant {
    fn desc(self, features: Features) -> &'static KernelDesc {
        match self {
            Self::AirScatter if features.areas => &air::AREA_SCATTER,
            Self::AirScatter => &air::SCATTER,
            Self::ShadeClip => &shade::CLIP,
            Self::ShadeSeen => &shade::SEEN,
            Self::ShadeLayered => &shade::LAYERED,
            Self::ShadeLayers => &shade::LAYERS,
            Self::ShadeSurfaces => &shade::SURFACES,
            Self::ShadePanes => &shade::PANES,
            Self::ShadeCasters => &shade::CASTERS,
            Self::LightPoints if features.areas && features.masks => {
                &shade::AREA_MASKED_LIGHT_POINTS
            }
            Self::LightPoints if features.masks => &shade::MASKED_LIGHT_POINTS,
            Self::LightPoints if features.areas => &shade::AREA_LIGHT_POINTS,
            Self::LightPoints => &shade::LIGHT_POINTS,
            Self::ShadeComposite => &shade::COMPOSITE,
            Self::MaskSurfaces => &mask::SURFACES,
            Self::HalfMaskSurfaces => &mask::HALF_SURFACES,
            Self::HostSurfaces => &mask::HOST_SURFACES,
            Self::HalfHostSurfaces => &mask::HALF_HOST_SURFACES,
            Self::MaskLookUp if features.areas => &mask::AREA_LOOK_UP,
            Self::MaskLookUp => &mask::LOOK_UP,
            Self::MaskBlur => &mask::BLUR,
            Self::MaskEnlarge => &mask::ENLARGE,
        }
    }
}

impl Kernels {
    pub(crate) fn of(&self, variant: Variant, features: Features) -> Result<Kernel, KernelError> {
        self.get(variant.desc(features), features)
    }

    /// # Panics
    /// If `prepare` has not asked for the kernel.
    #[cfg(feature = "picture")]
    pub(crate) fn known(&self, variant: Variant, features: Features) -> Kernel {
        self.of(variant, features).unwrap_or_else(|error| panic!("{error}"))
    }
}
