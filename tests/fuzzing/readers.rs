//! Files that scenes and `fstop compare` refer to.

use fstop::assets::brdf_file::BrdfFile;
use fstop::assets::bsdf_file::BsdfFile;
use fstop::assets::image_data::ImageData;
use fstop::assets::merl_file::MerlFile;
use fstop::assets::mesh::MeshData;
use fstop::assets::ptex::PtexFile;
use fstop::assets::{obj, ply, spd};
use fstop::bsdf::Lobe;
use fstop::bsdf::fourier::{FourierLobe, FourierTable};
use fstop::bsdf::measured::{MeasuredLobe, MeasuredTable};
use fstop::math::hash::{mix2, unit_float};
use fstop::math::sampling::cosine_hemisphere;
use fstop::math::{Vec2, spectrum};
use std::path::Path;

/// Every corner is a point, and what is stored for points is there for each.
fn sound(mesh: &MeshData) {
    let points = mesh.positions.len();
    let inside = |corner: &u32| (*corner as usize) < points;
    assert!(mesh.indices.iter().flatten().all(inside), "a corner beyond");
}

pub(super) fn ply(bytes: &[u8]) {
    if let Ok(mesh) = ply::parse(bytes) {
        sound(&mesh);
    }
}

pub(super) fn obj(bytes: &[u8]) {
    if let Ok(mesh) = obj::parse(bytes) {
        sound(&mesh);
    }
}

pub(super) fn ptex(bytes: &[u8]) {
    let Ok(file) = PtexFile::parse(bytes) else {
        return;
    };
    for face in file.faces() {
        for edge in 0..4 {
            let neighbor = face.neighbor(edge);
            assert!(neighbor.is_none_or(|n| file.face(n.face).is_some()));
        }
    }
}

/// A file of that content: some readers want a path, whose ending may tell the format.
fn with_file(ending: &str, bytes: &[u8], read: impl FnOnce(&Path)) {
    let file = tempfile::Builder::new().suffix(ending).tempfile();
    let file = file.expect("a temporary file");
    std::fs::write(file.path(), bytes).expect("a writable file");
    read(file.path());
}

/// Textures. The content decides on the format; only TGA has no signature and goes by its name.
pub(super) fn picture(bytes: &[u8]) {
    with_file(".tga", bytes, |path| {
        if let Ok(picture) = ImageData::load(path, &fstop::budget::Budget::unlimited()) {
            assert!(!picture.texels().is_empty());
        }
    });
}

/// The images of `fstop compare`.
pub(super) fn exr(bytes: &[u8]) {
    with_file(".exr", bytes, |path| {
        if let Ok(loaded) = fstop::film::read(path) {
            let pixels = loaded.image.pixels.len();
            let variances = loaded.image.variance.map_or(pixels, |v| v.len());
            assert_eq!(pixels, variances);
        }
    });
}

pub(super) fn spd(bytes: &[u8]) {
    if let Ok(spd::SpectrumFile { samples, .. }) = spd::parse(&String::from_utf8_lossy(bytes)) {
        assert!(samples.is_sorted_by(|a, b| a.0 < b.0));
        let color = spectrum::rgb_from_samples(&samples);
        // Values at the end of the range may sum up to more than there are numbers for.
        let tame = samples.iter().all(|s| s.1.abs() < 1e30 && s.0 < 1e30);
        assert!(!tame || color.is_finite(), "{color} of {samples:?}");
    }
}

pub(super) fn bsdf(bytes: &[u8]) {
    let Ok(file) = BsdfFile::parse(bytes) else {
        return;
    };
    let table = FourierTable::new(file);
    scatter(&Lobe::Fourier(FourierLobe::new(&table)));
}

pub(super) fn merl(bytes: &[u8]) {
    if let Ok(file) = MerlFile::parse(bytes) {
        let table = MeasuredTable::from_merl(file);
        scatter(&Lobe::Measured(MeasuredLobe::new(&table)));
    }
}

pub(super) fn brdf(bytes: &[u8]) {
    if let Ok(file) = BrdfFile::parse(bytes) {
        let table = MeasuredTable::from_brdf(&file);
        scatter(&Lobe::Measured(MeasuredLobe::new(&table)));
    }
}

/// Values and samples are numbers.
fn scatter(lobe: &Lobe) {
    for i in 0..16 {
        let square = |k| Vec2::new(unit_float(mix2(i, k)), unit_float(mix2(i, k + 1)));
        let wo = cosine_hemisphere(square(0));
        let wi = cosine_hemisphere(square(2));
        assert!(!lobe.f(wo, wi).is_nan() && lobe.pdf(wo, wi) >= 0.0);
        if let Some(sample) = lobe.sample(wo, unit_float(mix2(i, 6)), square(4)) {
            assert!(!sample.f.is_nan() && sample.pdf >= 0.0);
        }
    }
}
