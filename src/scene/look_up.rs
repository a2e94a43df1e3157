//! Validation of a light's look-up tables, and conversion to the library's units.
use super::{
    SceneError,
    document::MaskTable,
    document_lights::{FilterTable, LightTable},
    source::SceneText,
    tables::Table,
};
use crate::model::{LookUp, MaskSettings, ShadowFilter};
use toml::Spanned;

/// Filter of a table; `None` without a table.
pub(super) fn filter(
    source: &SceneText<'_>,
    table: Option<&Spanned<FilterTable>>,
) -> Result<Option<ShadowFilter>, SceneError> {
    let Some(table) = table else { return Ok(None) };
    let check = Table { source, table };
    let taps = |taps: u32, least: u32, most: u32| {
        if (least..=most).contains(&taps) {
            return Ok(taps);
        }
        Err(check.fault("taps", format!("taps is {taps}"), &format!("{least} to {most} taps")))
    };
    Ok(Some(match *table.get_ref() {
        FilterTable::None {} => ShadowFilter::None,
        FilterTable::Bilinear {} => ShadowFilter::Bilinear,
        FilterTable::Spline {} => ShadowFilter::Spline,
        FilterTable::Pcf { taps: side } => {
            ShadowFilter::Pcf { taps: taps(side, 2, ShadowFilter::MAX_PCF)? }
        }
        FilterTable::Vogel { taps: count, radius } => {
            let valid = |v| (0.0..=ShadowFilter::MAX_RADIUS).contains(&v);
            let range = format!("0 to {} texels", ShadowFilter::MAX_RADIUS);
            ShadowFilter::Vogel {
                taps: taps(count, 1, ShadowFilter::MAX_VOGEL)?,
                radius: check.number("radius", radius, valid, &range)?,
            }
        }
    }))
}

pub(super) fn of_light(
    source: &SceneText<'_>,
    check: &Table<'_, LightTable>,
) -> Result<LookUp, SceneError> {
    let light = check.table.get_ref();
    let bias = |key, value: Option<f32>| value.map(|v| check.bias(key, v)).transpose();
    Ok(LookUp {
        filter: filter(source, light.filter.as_ref())?,
        bias: bias("bias", light.bias)?,
        slope_bias: bias("slope_bias", light.slope_bias)?,
        normal_bias: bias("normal_bias", light.normal_bias)?,
    })
}

pub(super) fn mask(
    source: &SceneText<'_>,
    table: &Spanned<MaskTable>,
) -> Result<MaskSettings, SceneError> {
    let check = Table { source, table };
    let MaskTable { half, taps, depth_scale, anisotropic, sensitivity, limit } = *table.get_ref();
    let usual = MaskSettings::default();
    let taps = taps.unwrap_or(usual.taps);
    if taps != 1 && !(3..=MaskSettings::MAX_TAPS).contains(&taps) || taps % 2 == 0 {
        let help = format!("an odd number, 3 to {}; 1 for no blur", MaskSettings::MAX_TAPS);
        return Err(check.fault("taps", format!("taps is {taps}"), &help));
    }
    if taps == 1 && anisotropic == Some(true) {
        let help = "remove it, or set taps to 3 or more";
        return Err(check.fault("anisotropic", "there is no blur: taps is 1", help));
    }
    let limit = limit.unwrap_or(usual.limit);
    if !(1..=MaskSettings::MAX_LIMIT).contains(&limit) {
        let help = format!("1 to {} masks", MaskSettings::MAX_LIMIT);
        return Err(check.fault("limit", format!("limit is {limit}"), &help));
    }
    let number = |key, value: Option<f32>, usual| {
        check.number(key, value.unwrap_or(usual), |v| (0.0..=1e6).contains(&v), "0 to 1e6")
    };
    Ok(MaskSettings {
        half: half.unwrap_or(usual.half),
        taps,
        depth_scale: number("depth_scale", depth_scale, usual.depth_scale)?,
        anisotropic: anisotropic.unwrap_or(usual.anisotropic),
        sensitivity: number("sensitivity", sensitivity, usual.sensitivity)?,
        limit,
    })
}
