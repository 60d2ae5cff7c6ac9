//! Layers of an image that is being rendered, for those who look on.

use super::{ImageLayers, LayerPixels};
use crate::film::{Film, FilmSpec, PixelBounds, Tile};

/// What samples have told the layers so far, but for Cryptomattes.
pub(crate) struct GrowingLayers {
    bounds: PixelBounds,
    scale: f64,
    sums: LayerPixels,
}

impl GrowingLayers {
    /// Of no samples; `None` where no layers are wanted.
    pub(crate) fn new(spec: &FilmSpec) -> Option<GrowingLayers> {
        let bounds = spec.pixel_bounds();
        Some(GrowingLayers {
            bounds,
            scale: f64::from(spec.scale),
            sums: LayerPixels::new(spec.layers, bounds.area())?,
        })
    }

    /// More samples, of a tile that is closed.
    pub(crate) fn add(&mut self, tile: &Tile) {
        let Some(more) = tile.layers() else {
            return;
        };
        self.sums
            .merge_sums(more, &tile.bounds().shared_rows(self.bounds));
    }

    /// All samples so far, where they are kept otherwise.
    pub(crate) fn replace(&mut self, film: &Film) {
        if let Some(all) = &film.layers {
            self.sums.sums.clone_from(&all.sums);
        }
    }

    /// The layers of some pixels.
    pub(crate) fn pixels(&self, square: PixelBounds) -> ImageLayers {
        let mut layers = ImageLayers::without_mattes(self.sums.set, square.area());
        let rows = self.bounds.shared_rows(square);
        layers.develop_sums(&self.sums, &rows, self.scale);
        layers
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CameraSample, LayerSample, MatteId, RenderSpace, SurfaceSample, all};
    use super::*;
    use crate::math::{DVec4, Rgb, UVec2, Vec2, Vec3};

    fn surface(x: f32) -> SurfaceSample {
        let mut surface = SurfaceSample::default();
        surface.set_albedo(Rgb::splat(0.1));
        surface.set_normal(Vec3::new(0.6, -0.8, 0.0));
        surface.set_p(Vec3::new(x, x.sin(), 3.0));
        surface.set_uv(Vec2::splat(x));
        surface
    }

    fn sample(x: f32, surface: &SurfaceSample) -> LayerSample<'_> {
        LayerSample {
            surface,
            space: &RenderSpace {
                origin: DVec4::X,
                depth: DVec4::Y,
            },
            camera: CameraSample::new(x.into(), x.cos().into(), Vec2::new(x.sin(), x)),
            mattes: ["a", "b"].map(MatteId::of),
        }
    }

    #[test]
    fn they_are_those_of_the_image() {
        let spec = FilmSpec {
            resolution: UVec2::new(3, 2),
            scale: 0.5,
            layers: all(),
            ..FilmSpec::default()
        };
        let (mut film, mut growing) = (Film::new(&spec), GrowingLayers::new(&spec).unwrap());
        for number in 0..3 {
            let mut tile = spec.tile(PixelBounds::new(UVec2::new(1, 0), UVec2::new(3, 2)));
            for (i, pixel) in tile.bounds().pixels().enumerate() {
                let x = 0.3 + i as f32 + 0.1 * number as f32;
                let surface = surface(x);
                let seen = sample(x, &surface);
                tile.add_layers(pixel, 0.5, Some(Some(&seen)), &[Rgb::ONE, Rgb::X]);
                tile.add_sample(pixel, Rgb::ONE, 0.5);
            }
            tile.close();
            growing.add(&tile);
            film.merge(tile);
        }
        let mut whole = film.develop().layers;
        whole.mattes.clear();
        let shown = growing.pixels(spec.pixel_bounds());
        assert_eq!(shown, whole);
        let square = growing.pixels(PixelBounds::new(UVec2::new(2, 1), UVec2::new(3, 2)));
        assert!(square.values(0).eq(whole.values(5)));
        assert!(!square.values(0).eq(whole.values(4)));
        let names = square.channels(&["rest".to_string(), "key".to_string()]);
        assert_eq!(names.len(), 16 + 6);
        assert!(
            square.values(0).count() > names.len(),
            "of lights without a name"
        );
        let mut again = GrowingLayers::new(&spec).unwrap();
        again.replace(&film);
        assert_eq!(again.pixels(spec.pixel_bounds()), whole);
    }
}
