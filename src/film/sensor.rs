//! Sensors by name: `Film "image" "string sensor"`, or `Camera "realistic" "string sensor"`.
//!
//! A preset says how many pixels there are and how far apart; the size follows. Classes of sensors, each with the figures of one that is
//! sold, not brands.

use crate::math::UVec2;
use crate::params::ParamReader;

/// Pixels and the distance between their middles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorPreset {
    /// What scenes call it.
    pub name: &'static str,
    /// Width and height in pixels.
    pub resolution: UVec2,
    /// Micrometers.
    pub pitch: f64,
}

const fn preset(name: &'static str, x: u32, y: u32, pitch: f64) -> SensorPreset {
    SensorPreset {
        name,
        resolution: UVec2 { x, y },
        pitch,
    }
}

/// From the largest to the smallest.
pub const SENSORS: [SensorPreset; 11] = [
    preset("medium-format-100", 11_664, 8_750, 4.6),
    preset("medium-format-50", 8_256, 6_192, 5.3),
    preset("full-frame-24", 6_000, 4_000, 6.0),
    preset("full-frame-60", 9_504, 6_336, 3.76),
    preset("super-35", 4_608, 3_164, 6.075),
    preset("aps-c-24", 6_000, 4_000, 3.92),
    preset("aps-c-small-24", 6_000, 4_000, 3.72),
    preset("four-thirds-20", 5_184, 3_888, 3.34),
    preset("one-inch-20", 5_472, 3_648, 2.41),
    preset("phone-12", 4_032, 3_024, 2.44),
    preset("phone-48", 8_064, 6_048, 1.22),
];

impl SensorPreset {
    /// The preset of this name.
    pub fn named(name: &str) -> Option<&'static SensorPreset> {
        SENSORS.iter().find(|preset| preset.name == name)
    }

    /// The one that a directive names. Those of pbrt-v4, which are spectral responses, change nothing.
    pub fn from_params(reader: &ParamReader) -> Option<&'static SensorPreset> {
        let name = reader.find_string("sensor")?;
        let preset = SensorPreset::named(name);
        if preset.is_none() {
            let names = SENSORS.map(|preset| preset.name).join(", ");
            let message = format!("no sensor is called \"{name}\" here; there are {names}");
            reader.warn("sensor", message);
        }
        preset
    }

    /// Width and height in mm.
    pub fn size_mm(&self) -> [f64; 2] {
        let pixels = self.resolution.as_dvec2().to_array();
        pixels.map(|n| 1e-3 * self.pitch * n)
    }

    /// The diagonal in mm of the largest film of `resolution` that the sensor has room for: all of it at its own proportions.
    pub fn diagonal_mm(&self, resolution: UVec2) -> f64 {
        let [width, height] = self.size_mm();
        let pixels = resolution.as_dvec2();
        let pitch = (width / pixels.x).min(height / pixels.y);
        pitch * pixels.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_have_the_sizes_of_their_classes() {
        // Nominal sizes of the classes, mm; within a pixel's border of some makers.
        for (name, nominal) in [
            ("full-frame-24", [36.0, 24.0]),
            ("full-frame-60", [35.7, 23.8]),
            ("aps-c-24", [23.5, 15.6]),
            ("aps-c-small-24", [22.3, 14.9]),
            ("four-thirds-20", [17.3, 13.0]),
            ("one-inch-20", [13.2, 8.8]),
            ("medium-format-50", [43.8, 32.8]),
            ("medium-format-100", [53.7, 40.2]),
            ("super-35", [28.0, 19.2]),
        ] {
            let size = SensorPreset::named(name).unwrap().size_mm();
            for (found, nominal) in size.iter().zip(nominal) {
                assert!((found - nominal).abs() < 0.1, "{name}: {found} mm");
            }
        }
        assert_eq!(SensorPreset::named("cie1931"), None);
    }

    #[test]
    fn another_resolution_fits_inside() {
        let sensor = SensorPreset::named("full-frame-24").unwrap();
        assert!((sensor.diagonal_mm(sensor.resolution) - 36f64.hypot(24.0)).abs() < 1e-12);
        // 16:9 uses all of the width, a square all of the height.
        let wide = sensor.diagonal_mm(UVec2::new(1600, 900));
        assert!((wide - 36f64.hypot(20.25)).abs() < 1e-12);
        let square = sensor.diagonal_mm(UVec2::new(10, 10));
        assert!((square - 24f64.hypot(24.0)).abs() < 1e-12);
    }
}
