//! Whatever a file says, reading ends, and a lens that is read can be traced.

use fstop::optics::prescription::{
    Glasses, PrescriptionError, json, optbench, optiland, oslo, seq, zmx,
};
use fstop::optics::{Prescription, Surface};
use proptest::prelude::*;

fn sound(read: Result<Prescription, PrescriptionError>) {
    let Ok(lens) = read else { return };
    let finite = |s: &Surface| {
        s.curvature().is_finite()
            && s.thickness.is_finite()
            && s.aperture > 0.0
            && s.aperture.is_finite()
            && s.index >= 1.0
    };
    assert!(lens.surfaces.iter().all(finite), "{lens:?}");
    assert!(lens.film_distance.is_finite());
    assert!(lens.at_position(None, 1e3).is_ok());
}

const NUMBER: &str = "-?[0-9]{1,3}|-?[0-9]\\.[0-9]{1,3}|1e-?[0-9]{1,3}|nan|inf|é";

/// Words of a format between numbers.
fn text(words: &str, separators: &'static [&'static str]) -> impl Strategy<Value = String> {
    let word = prop_oneof![words, NUMBER, words];
    let separator = prop::sample::select(separators);
    prop::collection::vec((word, separator), 0..80)
        .prop_map(|parts| parts.into_iter().map(|(w, s)| w + s).collect())
}

const BLANKS: &[&str] = &[" ", "\n", "; ", " "];

proptest! {
    #[test]
    fn code_v(text in text("SO|S|SI|S1|RDM|N|DIM|EPD|FNO|YAN|WL|REF|VUY|STO|CIR|EDG|K|A|B|J|ADE|PRV|PWL|END|NBK7|517642|1.5:60|&|'|!", BLANKS)) {
        sound(seq::parse(&format!("SO 0 1e11\nEPD 3\nS 50 5 NBK7\nSTO\n{text}\nSI 0 0"), &Glasses::COMMON));
        sound(seq::parse(&text, &Glasses::COMMON));
    }

    #[test]
    fn oslo_files(text in text("LEN|NEW|NXT|UNI|EBR|ANG|OBH|GIH|NAO|WV|RD|CV|TH|AIR|GLA|MOD|AP|CHK|AST|CC|AD|AG|TLA|END|N-BK7|//", BLANKS)) {
        sound(oslo::parse(&format!("LEN NEW\nEBR 3\nTH 1e20\nNXT\nAST\nGLA 1.5\n{text}\nNXT\nTH 9\nNXT\nEND"), &Glasses::COMMON));
    }

    #[test]
    fn zemax(text in text("SURF|STOP|TYPE|ODDASPHE|EVENASPH|COORDBRK|ENPD|FNUM|OBNA|FLOA|FTYP|XFLN|YFLN|VDYN|VCYN|CURV|CONI|PARM|DISZ|GLAS|DIAM|CLAP|MNUM 2|THIC 0|THIC 1|THIC 1 1 5|THIC 1 2 6|MAZH", BLANKS)) {
        sound(zmx::parse(&format!("MODE SEQ\nENPD 3\nYFLN 0 {text}\nSURF 0\nDISZ INFINITY\nSURF 1\nSTOP\nGLAS N-BK7\n{text}\nSURF\nDISZ 3\nSURF\n"), &Glasses::COMMON));
    }

    #[test]
    fn optical_bench(text in text("AS|FS|CG|Infinity|d1|Bf|d0|Focal Length|\\[lens data\\]|\\[aspherical data\\]|\\[constants\\]|AsphericalOddCount|1\t50\t2\t1.5\t9", &["\t", "\n", "\t"])) {
        sound(optbench::parse(&format!("[variable distances]\nF-Number\t4\nFocal Length\t50\t80\nd1\t1\t2\n{text}\n[lens data]\n1\tAS\td1\t\t9\n{text}"), &Glasses::COMMON));
    }

    #[test]
    fn jsons(value in "[-+0-9.eE\\[\\]{}\",:a-z]{0,40}|-?1e[0-9]{1,3}", key in "radius|thickness|ior|semi_aperture|conic_constant|aspheric_terms|abbe|glass|stop|dispersion", n in any::<u32>()) {
        let entry = format!("{{\"radius\": 50, \"thickness\": 2, \"ior\": 1.5, \"semi_aperture\": 3, \"{key}\": {value}}}");
        sound(json::parse(&format!("{{\"surfaces\": [{entry}]}}")));
        let text = include_str!("lenses/optiland.json");
        // One place overwritten.
        let at = n as usize % text.len();
        let text = format!("{}{value}{}", &text[..at], &text[(at + n as usize % 9).min(text.len())..]);
        sound(optiland::parse(&text, &Glasses::COMMON));
    }
}

#[test]
fn deep_long_and_large_files_end() {
    let deep = "[".repeat(100_000);
    assert!(json::parse(&deep).is_err() && optiland::parse(&deep, &Glasses::COMMON).is_err());
    let many = "S 50 1 1.5:60\nS 0 1\n".repeat(20_000);
    let error = seq::parse(
        &format!("EPD 5\nYAN 1\nSO 0 1e12\n{many}"),
        &Glasses::COMMON,
    )
    .unwrap_err();
    assert!(
        error.to_string().contains("more than 1000 surfaces"),
        "{error}"
    );
    // As many as there may be, all of them open, in every field.
    let many = "S 5e6 1 1.5:60\nS 0 1\n".repeat(490);
    let fields = "1 ".repeat(90);
    sound(seq::parse(
        &format!("EPD 5\nYAN {fields}\nSO 0 1e12\nS 0 1\nSTO\n{many}\nSI"),
        &Glasses::COMMON,
    ));
}
