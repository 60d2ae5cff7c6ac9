use fstop::build::build;
use fstop::film::Image;
use fstop::render::{Progress, TILE_SIZE, render};
use fstop::samplers::{Sampler, SamplerSpec};
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use std::path::Path;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let a: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    (a[11].parse::<f64>().unwrap()) / 100.0
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let variants: Vec<u32> = args[1].split(',').map(|s| s.parse().unwrap()).collect();
    let seeds = 8u64;
    for scene in ["box", "lens", "glossy", "motion", "lamps"] {
        let sources = SourceMap::new();
        let file = sources.open(&Path::new("examples/sampler_curves").join(scene).with_extension("pbrt")).unwrap();
        let (s, _) = read_scene(&sources, file, &ReadSettings::default());
        let mut frame = s.frames.into_iter().next().unwrap(); frame.options.film.shrink(900); let mut shot = build(frame, 1).0.unwrap().shot;
        println!("{scene}");
        for &v in &variants {

            let mut line = format!("  {v}: ");
            let t = cpu();
            for n in [4u32, 8, 16, 32, 64, 256] {
                let spec = if v == 99 { SamplerSpec::random(n) } else { SamplerSpec::sobol(n) };
                let images: Vec<Image> = (0..seeds)
                    .map(|k| {
                        shot.sampler = Sampler::new(&spec, 1000 + k);
                        render(&shot, TILE_SIZE, &Progress::hidden()).develop()
                    })
                    .collect();
                let (mut sum, mut count) = (0.0, 0.0);
                let total: f64 = images[0].pixels.iter().map(|p| p.as_dvec3().element_sum()).sum();
                let floor = (0.01 * total / images[0].pixels.len() as f64 / 3.0).powi(2);
                for i in 0..images[0].pixels.len() {
                    let mean = images.iter().map(|m| m.pixels[i].as_dvec3()).sum::<glam::DVec3>() / seeds as f64;
                    for m in &images {
                        let d = m.pixels[i].as_dvec3() - mean;
                        sum += (d * d / (mean * mean + floor)).element_sum() / (seeds - 1) as f64;
                    }
                    count += 3.0;
                }
                line += &format!("{:.3e} ", sum / count);
            }
            println!("{line}  {:.2} s", cpu() - t);
        }
    }
}
