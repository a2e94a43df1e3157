//! Splats under an affine map.
use glam::{DMat3, DQuat, DVec3, Mat4};
use gobo::model::Gaussian;

/// Each sweep rotates all three pairs of columns; columns of 3 x 3 matrices are orthogonal up to rounding
/// after five or six.
const SWEEPS: usize = 8;

/// The splat under an affine map `world`: a Gaussian stays a Gaussian.
pub(crate) fn placed(splat: &Gaussian, world: &Mat4) -> Gaussian {
    let axes =
        DMat3::from_quat(splat.rotation.as_dquat()) * DMat3::from_diagonal(splat.sigma.as_dvec3());
    let (rotation, sigma) = principal_axes(DMat3::from_mat4(world.as_dmat4()) * axes);
    Gaussian {
        center: world.transform_point3(splat.center),
        rotation: rotation.as_quat(),
        sigma: sigma.as_vec3(),
        ..*splat
    }
}

/// Rotation and deviations of the unit Gaussian under `axes`: the matrix's singular vectors and values
/// (one-sided Jacobi: Hestenes 1958), which keep the thin axis of a needle exact where the covariance loses
/// it.
fn principal_axes(axes: DMat3) -> (DQuat, DVec3) {
    let mut columns = [axes.x_axis, axes.y_axis, axes.z_axis];
    for _ in 0..SWEEPS {
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b) = (columns[i], columns[j]);
            let overlap = a.dot(b);
            if overlap == 0.0 {
                continue;
            }
            let slope = (b.length_squared() - a.length_squared()) / (2.0 * overlap);
            let tangent = slope.signum() / (slope.abs() + slope.hypot(1.0));
            let cosine = 1.0 / tangent.hypot(1.0);
            let sine = cosine * tangent;
            (columns[i], columns[j]) = (a * cosine - b * sine, a * sine + b * cosine);
        }
    }
    let sigma = DVec3::from_array(columns.map(DVec3::length));
    // The third axis is the cross product of the two longest: it may be too short to have a direction.
    let mut order = [0, 1, 2];
    order.sort_by(|&a: &usize, &b| sigma[b].total_cmp(&sigma[a]));
    let longest = columns[order[0]].normalize_or(DVec3::X);
    let second = columns[order[1]].reject_from_normalized(longest);
    let second = second.try_normalize().unwrap_or_else(|| longest.any_orthonormal_vector());
    let frame = DMat3::from_cols(longest, second, longest.cross(second));
    (DQuat::from_mat3(&frame).normalize(), DVec3::from_array(order.map(|i| sigma[i])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    fn covariance(splat: &Gaussian) -> DMat3 {
        let axes = DMat3::from_quat(splat.rotation.as_dquat().normalize());
        let sigma = splat.sigma.as_dvec3();
        axes * DMat3::from_diagonal(sigma * sigma) * axes.transpose()
    }

    /// Covariance = M C M^T, also under shear, mirrors and flat needles.
    #[test]
    fn a_placed_splat_has_the_mapped_covariance() {
        let splat = Gaussian {
            center: Vec3::new(1.0, 2.0, 3.0),
            rotation: Quat::from_xyzw(0.3, -0.2, 0.5, 0.7).normalize(),
            sigma: Vec3::new(1.0, 0.1, 0.01),
            ..Gaussian::default()
        };
        let turn = Quat::from_xyzw(0.1, 0.7, -0.2, 0.4).normalize();
        for scale in [Vec3::ONE, Vec3::new(2.0, 0.5, -3.0), Vec3::new(1.0, 1.0, 1e-3)] {
            let world = Mat4::from_scale_rotation_translation(scale, turn, Vec3::X)
                * Mat4::from_rotation_x(0.7)
                * Mat4::from_scale(Vec3::new(1.0, 3.0, 1.0));
            let placed = placed(&splat, &world);
            let map = DMat3::from_mat4(world.as_dmat4());
            let wanted = map * covariance(&splat) * map.transpose();
            let far = (covariance(&placed) - wanted).to_cols_array();
            let size =
                wanted.to_cols_array().iter().fold(0.0, |most: f64, part| most.max(part.abs()));
            // Rounding of a rotation and deviations to 32 bits.
            assert!(far.iter().all(|part| part.abs() < 1e-6 * size), "{scale}: {far:?} of {size}");
            assert_eq!(placed.center, world.transform_point3(splat.center));
        }
    }
}
