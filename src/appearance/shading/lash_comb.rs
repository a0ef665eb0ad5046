//! The upper lashes as what stands before the globe, in what it mirrors and in the light that falls on it: a comb on a sheet
//! that curls up before the lid. Head frame, millimetres. Twin: `shaders/lib/lash_comb.wgsl`.

use super::mix;
use crate::optics::smoothstep::smoothstep;
use glam::DVec3;

/// They are a comb of their own, with the number of those that are drawn and not their places (choices by
/// the look of macro photographs). How much they rise (1/mm: their height over the margin is this times the square of how far they stand
/// before it), how far they reach forward (mm), and how dark they are.
pub const LASH_CURL: f64 = 0.09;
const LASH_REACH_MM: f64 = 8.0;
pub const LASH_DARK: f64 = 0.8;
/// Their comb, rad/mm (three to a millimetre of lid), and the share of it that is lash.
const LASH_COMB: f64 = 19.0;
pub const LASH_SHARE: f64 = 0.29;

/// How much steeper than the lowest ray that meets the sheet a ray rises where half of the lashes that it crosses are there: not every lash
/// curls alike (a choice).
const LASH_EVEN: f64 = 0.45;

/// How steep the lowest ray is that meets them from a place `upper_gap` mm below the upper lid's margin: its rise for each unit forward.
pub fn lash_rise(upper_gap: f64) -> f64 {
    2.0 * (LASH_CURL * upper_gap.max(0.0)).sqrt()
}

/// Share of a ray in the unit direction `r`, from a place `x` mm aside and `upper_gap` mm below the upper lid's margin,
/// that they let pass where it is blurred by `near` mm at the place and `far` mm for each millimetre that it goes forward: what is
/// wider than the comb's teeth sees what they take in the mean.
pub fn lashes_left(x: f64, r: DVec3, upper_gap: f64, near: f64, far: f64) -> f64 {
    let forward = (-r.z).max(0.2);
    let rise = r.y / forward;
    let crosses = rise * rise - 4.0 * LASH_CURL * upper_gap.max(0.0);
    let reach = (rise - crosses.max(0.0).sqrt()) / (2.0 * LASH_CURL);
    let aside = x + r.x / forward * reach;
    let waves = 2.5 * (aside * 2.3).sin() + 1.7 * (aside * 5.1).sin();
    let comb = (aside * LASH_COMB + waves).sin();
    let steep = 1.0 + r.x.abs() / forward / crosses.max(0.01).sqrt();
    let turn = LASH_COMB * (near * steep + far * reach);
    let tooth = mix(
        LASH_SHARE,
        smoothstep(0.3, 0.95, comb),
        (-turn * turn).exp(),
    );
    let there = smoothstep(0.0, 2.0 * LASH_EVEN, crosses)
        * smoothstep(0.0, 0.3, rise)
        * (1.0 - smoothstep(0.5 * LASH_REACH_MM, LASH_REACH_MM, reach));
    1.0 - LASH_DARK * there * tooth
}
