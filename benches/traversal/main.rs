//! Rays per second through our 8-wide tree, beside obvhs's own traversal of its binary and of its
//! compressed 8-wide tree (neither of which is watertight), and beside Embree where it is there.
//!
//! `cargo bench --bench traversal [-- --rounds N] [--alone] [--embree PROGRAM]`; `benches/embree/run.sh` builds
//! the program and runs both. One thread; all contenders take turns within every round, the clock is
//! the thread's processor time, and the best round counts.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stdout)]

mod clock;
mod contenders;
mod embree;
mod meshes;
mod rays;

use clock::seconds;
use contenders::{Contender, CwBvhTree, Ours, OursWithSurfaces, Query, Tree2};
use embree::Embree;
use meshes::Mesh;
use rays::{RaySet, SETS};
use std::path::PathBuf;

/// Million rays a second of every contender, by the best of the rounds so far.
struct Row {
    name: String,
    best: Vec<f64>,
    hits: Vec<usize>,
}

/// Ours, ours with the surface at the hit, and obvhs's two.
const NAMES: [&str; 4] = ["fstop", "+surface", "Bvh2", "CwBvh"];
/// The two of Embree, where it runs.
const EMBREE_NAMES: [&str; 2] = ["Embree", "robust"];

struct Arguments {
    rounds: usize,
    /// Without the others: for comparing two builds of ours, and for profiles.
    alone: bool,
    embree: Option<PathBuf>,
}

fn arguments() -> Arguments {
    let mut found = Arguments {
        rounds: 5,
        alone: false,
        embree: None,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--rounds" => {
                found.rounds = words
                    .next()
                    .and_then(|n| n.parse().ok())
                    .expect("--rounds takes a number");
            }
            "--alone" => found.alone = true,
            "--embree" => found.embree = words.next().map(PathBuf::from),
            // What cargo adds, and filters.
            _ => {}
        }
    }
    found
}

fn main() {
    let arguments = arguments();
    let mut rows = Vec::new();
    for mesh in [meshes::ball(), meshes::soup()] {
        rows.extend(measure(&mesh, &arguments));
    }
    if arguments.alone {
        print_alone(&rows);
    } else {
        print(&rows, arguments.embree.is_some());
    }
}

fn measure(mesh: &Mesh, arguments: &Arguments) -> Vec<Row> {
    let ours = Ours::new(mesh);
    let statistics = ours.statistics();
    println!(
        "{}: {} triangles, {} bytes each with their vertices, {} nodes",
        mesh.name,
        statistics.triangles,
        statistics.bytes / statistics.triangles,
        statistics.nodes
    );
    let others = (!arguments.alone).then(|| (Tree2::new(mesh), CwBvhTree::new(mesh)));
    let sets: Vec<RaySet> = SETS.iter().map(|&kind| RaySet::new(kind, &ours)).collect();
    let mut embree = arguments
        .embree
        .as_ref()
        .map(|program| Embree::start(program, mesh, &sets).expect("the Embree program runs"));
    let mut rows = Vec::new();
    for (number, set) in sets.iter().enumerate() {
        for &query in set.kind.queries() {
            let mut row = Row {
                name: format!("{} {} {query}", mesh.name, set.kind.name()),
                best: vec![0.0; NAMES.len() + EMBREE_NAMES.len()],
                hits: vec![0; NAMES.len() + EMBREE_NAMES.len()],
            };
            for _ in 0..arguments.rounds {
                let mut took = vec![run(&ours, set, query)];
                if let Some((tree2, cw)) = &others {
                    took.push(run(&OursWithSurfaces(&ours), set, query));
                    took.push(run(tree2, set, query));
                    took.push(run(cw, set, query));
                }
                if let Some(embree) = &mut embree {
                    for robust in [false, true] {
                        let answer = embree.run(robust, number, query);
                        took.push(answer.expect("the Embree program answers"));
                    }
                }
                for (i, (time, hits)) in took.into_iter().enumerate() {
                    row.best[i] = row.best[i].max(set.rays.len() as f64 / time / 1e6);
                    row.hits[i] = hits;
                }
            }
            rows.push(row);
        }
    }
    rows
}

/// Processor seconds for all rays of a set, and how many hit something.
fn run(contender: &impl Contender, set: &RaySet, query: Query) -> (f64, usize) {
    seconds(|| match query {
        Query::Closest => {
            let hits = set.rays.iter().filter(|ray| contender.closest(ray));
            hits.count()
        }
        Query::Any => set.rays.iter().filter(|ray| contender.any(ray)).count(),
    })
}

fn print_alone(rows: &[Row]) {
    let mut log = 0.0;
    for row in rows {
        println!("{:26}{:10.3}{:>12}", row.name, row.best[0], row.hits[0]);
        log += row.best[0].ln();
    }
    let mean = (log / rows.len() as f64).exp();
    println!("{:26}{mean:10.3}", "geometric mean, Mrays/s");
}

fn print(rows: &[Row], with_embree: bool) {
    let mut names = NAMES.to_vec();
    if with_embree {
        names.extend(EMBREE_NAMES);
    }
    print!("{:26}", "Mrays/s");
    for name in &names {
        print!("{name:>10}");
    }
    print!("{:>12}", "/ obvhs");
    if with_embree {
        print!("{:>10}{:>10}", "/ Embree", "/ robust");
    }
    println!("{:>20}", "hits");
    let mut logs = [0.0; 3];
    for row in rows {
        print!("{:26}", row.name);
        for value in &row.best[..names.len()] {
            print!("{value:10.2}");
        }
        let peers = [row.best[2].max(row.best[3]), row.best[4], row.best[5]];
        let ratios = peers.map(|peer| row.best[0] / peer);
        print!("{:12.2}", ratios[0]);
        if with_embree {
            print!("{:10.2}{:10.2}", ratios[1], ratios[2]);
        }
        let hits = &row.hits[..names.len()];
        let most = hits.iter().max().copied().unwrap_or(0);
        let apart = most - hits.iter().min().copied().unwrap_or(0);
        println!("{most:>12} (±{apart})");
        for (sum, ratio) in logs.iter_mut().zip(ratios) {
            *sum += ratio.ln();
        }
    }
    let means = logs.map(|sum| (sum / rows.len() as f64).exp());
    print!("{:66}{:12.2}", "geometric mean", means[0]);
    if with_embree {
        print!("\n{:98}{:10.2}{:10.2}", "", means[1], means[2]);
    }
    println!();
}
