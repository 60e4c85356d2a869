//! What a light sees: the rays of a reflective shadow map, and where in the map a point of the scene lies.
//!
//! Dachsbacher and Stamminger render perspective maps for spots and orthographic ones for suns. A map here is a disk
//! with pixels
//! of equal solid angle (equal area for suns), which does for lamps that shine all around as well: directions about
//! an axis by Lambert's azimuthal projection, the disk from the square by concentric squares (P. Shirley, K. Chiu, A Low
//! Distortion Map Between Disk and Square, 1997).

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glam::{Mat3, Vec2, Vec3};

/// A light without extent, as a map is rendered from it.
pub struct Eye {
    /// Third column: the middle of the map, a unit vector along which light travels.
    frame: Mat3,
    shape: Shape,
}

enum Shape {
    /// All directions from `position` that are at most `half_angle` (radians) from the axis.
    Lamp { position: Vec3, half_angle: f32, lobe: Lobe },
    /// Parallel light that comes through a disk of `radius` metres before the scene.
    Sun { middle: Vec3, radius: f32, irradiance: Vec3 },
}

/// Intensity by direction, W/sr.
pub enum Lobe {
    /// The same everywhere in the cone, smooth over the last `penumbra` radians of it.
    Cone { intensity: Vec3, penumbra: f32 },
    /// That of a piece of a diffuse emitter: proportional to the cosine with its normal.
    Cosine { intensity: Vec3 },
}

/// A ray of a map.
pub struct EyeRay {
    pub origin: Vec3,
    pub direction: Vec3,
    /// W for each unit of [`Eye::measure`].
    pub power: Vec3,
}

impl Eye {
    /// A lamp that shines along `axis` up to `half_angle`.
    pub fn lamp(position: Vec3, axis: Vec3, half_angle: f32, lobe: Lobe) -> Eye {
        Eye { frame: frame(axis), shape: Shape::Lamp { position, half_angle, lobe } }
    }

    /// A sun over a scene that a ball holds.
    pub fn sun(direction: Vec3, irradiance: Vec3, centre: Vec3, radius: f32) -> Eye {
        // Twice the radius away, so that rays start outside whatever the rounding.
        Eye {
            frame: frame(direction),
            shape: Shape::Sun { middle: centre - 2.0 * radius * direction, radius, irradiance },
        }
    }

    /// What a map covers: solid angle in sr, of suns area in m².
    pub fn measure(&self) -> f32 {
        match self.shape {
            Shape::Lamp { half_angle, .. } => 4.0 * PI * (0.5 * half_angle).sin().powi(2),
            Shape::Sun { radius, .. } => PI * radius * radius,
        }
    }

    /// The ray through a point of the unit square.
    pub fn ray(&self, at: Vec2) -> EyeRay {
        let disk = square_to_disk(at);
        match &self.shape {
            Shape::Lamp { position, half_angle, lobe } => {
                let direction = self.frame * lifted(disk * (0.5 * half_angle).sin());
                let angle = self.frame.z_axis.angle_between(direction);
                let power = lobe.intensity(angle, *half_angle);
                EyeRay { origin: *position, direction, power }
            }
            Shape::Sun { middle, radius, irradiance } => {
                let origin = *middle + *radius * (self.frame * disk.extend(0.0));
                EyeRay { origin, direction: self.frame.z_axis, power: *irradiance }
            }
        }
    }

    /// The surroundings of a point of the scene in the map.
    pub fn about(&self, point: Vec3) -> About<'_> {
        let middle = match self.shape {
            Shape::Lamp { position, half_angle, .. } => {
                let towards = (point - position).try_normalize().unwrap_or(self.frame.z_axis);
                Middle::Direction(frame(into_cone(towards, self.frame.z_axis, half_angle)))
            }
            Shape::Sun { middle, radius, .. } => {
                let across = self.frame.transpose() * (point - middle) / radius;
                Middle::Disk(across.truncate())
            }
        };
        About { eye: self, middle }
    }
}

/// A map around a point of the scene, drawn on a unit disk that covers the whole map wherever the point is.
pub struct About<'a> {
    eye: &'a Eye,
    middle: Middle,
}

enum Middle {
    /// Third column: the direction of the point.
    Direction(Mat3),
    Disk(Vec2),
}

impl About<'_> {
    /// The point of the unit square that lies at `offset` from the middle, which is a part of the unit disk;
    /// `None` outside of the map.
    pub fn at(&self, offset: Vec2) -> Option<Vec2> {
        let disk = match (&self.eye.shape, &self.middle) {
            (Shape::Lamp { half_angle, .. }, Middle::Direction(middle)) => {
                let direction = middle * lifted(offset * widest(*half_angle));
                projected(self.eye.frame.transpose() * direction) / (0.5 * half_angle).sin()
            }
            // The disk's diameter reaches from one end to the other.
            (_, Middle::Disk(middle)) => *middle + 2.0 * offset,
            _ => return None,
        };
        (disk.length_squared() <= 1.0).then(|| disk_to_square(disk))
    }

    /// [`Eye::measure`] of the whole unit disk.
    pub fn measure(&self) -> f32 {
        match self.eye.shape {
            Shape::Lamp { half_angle, .. } => 4.0 * PI * widest(half_angle).powi(2),
            Shape::Sun { .. } => 4.0 * self.eye.measure(),
        }
    }
}

impl Lobe {
    fn intensity(&self, angle: f32, half_angle: f32) -> Vec3 {
        match self {
            Lobe::Cone { intensity, penumbra } => {
                let x = if *penumbra > 0.0 { ((half_angle - angle) / penumbra).clamp(0.0, 1.0) } else { 1.0 };
                *intensity * (x * x * (3.0 - 2.0 * x))
            }
            Lobe::Cosine { intensity } => *intensity * angle.cos().max(0.0),
        }
    }
}

/// A frame whose third column is a unit vector.
fn frame(axis: Vec3) -> Mat3 {
    let (s, t) = axis.any_orthonormal_pair();
    Mat3::from_cols(s, t, axis)
}

/// The nearest direction of a cone.
fn into_cone(direction: Vec3, axis: Vec3, half_angle: f32) -> Vec3 {
    if axis.angle_between(direction) <= half_angle {
        return direction;
    }
    let aside = (direction - direction.dot(axis) * axis).try_normalize().unwrap_or(axis.any_orthonormal_vector());
    half_angle.cos() * axis + half_angle.sin() * aside
}

/// Sine of half of the widest angle between two directions of a cone.
fn widest(half_angle: f32) -> f32 {
    half_angle.min(FRAC_PI_2).sin()
}

/// The direction at angle θ from +Z for the point at sin(θ/2) of the disk: Lambert's projection.
fn lifted(disk: Vec2) -> Vec3 {
    let square = disk.length_squared().min(1.0);
    (2.0 * (1.0 - square).sqrt() * disk).extend(1.0 - 2.0 * square)
}

/// The inverse of [`lifted`].
fn projected(direction: Vec3) -> Vec2 {
    let cos_half = (0.5 * (1.0 + direction.z)).max(1e-12).sqrt();
    direction.truncate() / (2.0 * cos_half)
}

fn square_to_disk(at: Vec2) -> Vec2 {
    let p = 2.0 * at - Vec2::ONE;
    if p == Vec2::ZERO {
        return p;
    }
    let (radius, angle) =
        if p.x.abs() > p.y.abs() { (p.x, FRAC_PI_4 * p.y / p.x) } else { (p.y, FRAC_PI_2 - FRAC_PI_4 * p.x / p.y) };
    radius * Vec2::from_angle(angle)
}

fn disk_to_square(disk: Vec2) -> Vec2 {
    let radius = disk.length();
    let angle = disk.to_angle();
    let quarter = (angle / FRAC_PI_2).round();
    let aside = radius * (angle - quarter * FRAC_PI_2) / FRAC_PI_4;
    let p = match quarter as i32 {
        0 => Vec2::new(radius, aside),
        1 => Vec2::new(-aside, radius),
        -1 => Vec2::new(aside, -radius),
        _ => Vec2::new(-radius, -aside),
    };
    0.5 * (p + Vec2::ONE)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_1_SQRT_2, TAU};

    use super::*;

    fn eyes() -> [Eye; 3] {
        let axis = Vec3::new(0.3, -0.9, 0.2).normalize();
        let lobe = || Lobe::Cone { intensity: Vec3::ONE, penumbra: 0.0 };
        [
            Eye::lamp(Vec3::new(1.0, 2.0, 3.0), axis, PI, lobe()),
            Eye::lamp(Vec3::new(1.0, 2.0, 3.0), axis, 0.4, lobe()),
            Eye::sun(axis, Vec3::ONE, Vec3::ZERO, 5.0),
        ]
    }

    #[test]
    fn a_point_of_the_scene_is_where_its_ray_went_through() {
        for eye in eyes() {
            for (x, y) in [(0.1, 0.2), (0.9, 0.3), (0.5, 0.8), (0.31, 0.49), (0.5, 0.5)] {
                let wanted = Vec2::new(x, y);
                let ray = eye.ray(wanted);
                let found = eye.about(ray.origin + 3.0 * ray.direction).at(Vec2::ZERO).expect("inside");
                assert!((found - wanted).length() < 2e-3, "{found} instead of {wanted}");
            }
        }
    }

    #[test]
    fn equal_parts_of_the_disk_about_a_point_are_equal_parts_of_the_map() {
        // Points uniform over the disk about any point fall on every quarter of the map alike, and their share in all
        // is that
        // of the measures.
        for eye in eyes() {
            let about = eye.about(Vec3::new(-1.0, 0.5, 1.0));
            let (n, mut quarters) = (400_000u32, [0u32; 4]);
            for i in 0..n {
                let (r, a) = (((i as f32 + 0.5) / n as f32).sqrt(), TAU * (i as f32 * 0.618_034).fract());
                if let Some(at) = about.at(r * Vec2::from_angle(a)) {
                    quarters[usize::from(at.x > 0.5) + 2 * usize::from(at.y > 0.5)] += 1;
                }
            }
            let wanted = f64::from(n) * f64::from(eye.measure() / about.measure()) / 4.0;
            for q in quarters {
                assert!((f64::from(q) / wanted - 1.0).abs() < 0.02, "{quarters:?}, expected {wanted}");
            }
        }
    }

    #[test]
    fn a_hemisphere_of_a_diffuse_emitter_has_pi_times_its_intensity() {
        let lobe = Lobe::Cosine { intensity: Vec3::ONE };
        let eye = Eye::lamp(Vec3::ZERO, Vec3::Z, FRAC_PI_2, lobe);
        assert!((lifted(Vec2::new(FRAC_1_SQRT_2, 0.0)).z).abs() < 1e-6);
        let n = 200;
        let pixel = eye.measure() / (n * n) as f32;
        let flux: f32 = (0..n * n)
            .map(|i| pixel * eye.ray(Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32).power.x)
            .sum();
        assert!((flux / PI - 1.0).abs() < 1e-4, "{flux}");
    }
}
