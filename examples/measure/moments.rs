//! Power moments of the optical depth (Peters et al. 2017; Münstermann et al. 2018, section 3).
use crate::rivals::{Hit, optical_depth};
use gobo::glam::Vec3;

/// Most moments, with the total.
const MOST: usize = 9;
/// Weight between the lower bound of the absorbed light and the upper one.
const OVERESTIMATION: f64 = 0.25;
/// Steps of Newton's method, which from a bound of 1e12 needs less than 100.
const STEPS: u32 = 200;

/// A number of moments per channel: 4, 6 or 8.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moments {
    /// Total, and moments of depths in -1..1, per channel.
    sums: [[f64; MOST]; 3],
    count: usize,
}

/// Published weight of the moments of [`uniform`] in biased 32-bit moments.
fn bias(count: usize) -> f64 {
    match count {
        4 => 5e-7,
        6 => 5e-6,
        _ => 5e-5,
    }
}

/// Even moments towards which moments are biased, as published.
fn uniform(count: usize) -> &'static [f64] {
    match count {
        4 => &[0.375, 0.375],
        6 => &[0.48, 0.451, 0.45],
        _ => &[0.75, 0.676_666_666_666_666_6, 0.63, 0.600_303_030_303_030_3],
    }
}

impl Moments {
    pub(crate) fn new(hits: &[Hit], count: usize) -> Self {
        let mut sums = [[0.0; MOST]; 3];
        for &(depth, light) in hits {
            let z = 2.0 * f64::from(depth) - 1.0;
            for (sums, tau) in sums.iter_mut().zip(optical_depth(light)) {
                for (power, sum) in (0..).zip(&mut sums[..=count]) {
                    *sum += tau * z.powi(power);
                }
            }
        }
        Self { sums, count }
    }

    pub(crate) fn light_at(&self, z: f32) -> Vec3 {
        let z = 2.0 * f64::from(z) - 1.0;
        Vec3::from_array(self.sums.map(|sums| {
            let total = sums[0];
            if total < 1e-9 {
                1.0
            } else {
                (-total * self.absorbed_share(&sums, z)).exp().min(1.0) as f32
            }
        }))
    }

    /// Estimate of the share of the optical depth that lies in front of `z`.
    fn absorbed_share(&self, sums: &[f64; MOST], z: f64) -> f64 {
        let (bias, uniform) = (bias(self.count), uniform(self.count));
        let mut moments = sums.map(|sum| sum / sums[0]);
        for (i, moment) in moments.iter_mut().enumerate().skip(1) {
            let to = if i % 2 == 0 { uniform.get(i / 2 - 1).copied() } else { Some(0.0) };
            *moment += (to.unwrap_or(0.0) - *moment) * bias;
        }
        // Depths of the distribution with these moments that has the largest possible weight at z.
        let size = self.count / 2 + 1;
        let kernel = solved(&moments, z, size);
        let mut at = vec![z];
        at.extend(roots(kernel));
        // Weight of each depth: the integral of its Lagrange polynomial.
        let weight = |i: usize| {
            let mut product = vec![1.0];
            for (j, other) in at.iter().enumerate().filter(|&(j, _)| j != i) {
                let scale = 1.0 / (at[i] - other);
                debug_assert!(j < size);
                product.push(0.0);
                for k in (0..product.len()).rev() {
                    let lower = if k > 0 { product[k - 1] } else { 0.0 };
                    product[k] = (lower - other * product[k]) * scale;
                }
            }
            product.iter().zip(&moments).map(|(a, b)| a * b).sum::<f64>()
        };
        let in_front = (1..at.len()).filter(|&i| at[i] < z).map(weight).sum::<f64>();
        let share = in_front + OVERESTIMATION * weight(0);
        if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 }
    }
}

/// Solution of the Hankel system of `size` moments for (1, z, z^2, ...); its matrix is positive definite.
fn solved(moments: &[f64], z: f64, size: usize) -> Vec<f64> {
    let row = |i: usize| (0..size).map(|j| moments[i + j]).collect::<Vec<_>>();
    let mut rows: Vec<Vec<f64>> = (0..size).map(row).collect();
    let mut right: Vec<f64> = (0..size as i32).map(|i| z.powi(i)).collect();
    for i in 0..size {
        let (done, rest) = rows.split_at_mut(i + 1);
        let pivot = &done[i];
        for (j, row) in (i + 1..).zip(rest) {
            let share = row[i] / pivot[i];
            row.iter_mut().zip(pivot).for_each(|(to, from)| *to -= share * from);
            right[j] -= share * right[i];
        }
    }
    for i in (0..size).rev() {
        let rest: f64 = (i + 1..size).map(|j| rows[i][j] * right[j]).sum();
        right[i] = (right[i] - rest) / rows[i][i];
    }
    right
}

/// Roots of a polynomial with only real roots, largest first: by Newton's method from above, which then
/// descends, and deflation.
fn roots(mut coefficients: Vec<f64>) -> Vec<f64> {
    let mut found = Vec::new();
    while let Some(&last) = coefficients.last().filter(|_| coefficients.len() > 1) {
        let most = coefficients.iter().map(|c| (c / last).abs()).fold(0.0, f64::max);
        let mut x = 1.0 + most;
        for _ in 0..STEPS {
            let (mut value, mut slope) = (0.0, 0.0);
            for c in coefficients.iter().rev() {
                slope = slope * x + value;
                value = value * x + c;
            }
            let next = x - value / slope;
            if next.is_nan() || next >= x {
                break;
            }
            x = next;
        }
        found.push(x);
        // Division by (x - root).
        let mut carry = 0.0;
        for c in coefficients.iter_mut().rev() {
            carry = carry * x + *c;
            *c = carry;
        }
        coefficients.remove(0);
    }
    found
}
