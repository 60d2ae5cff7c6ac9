//! Embree in a program of its own (`benches/embree/rays.c`), driven through pipes so that it takes
//! turns with the others. Nothing of it is part of fstop.

use crate::contenders::Query;
use crate::meshes::Mesh;
use crate::rays::RaySet;
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The running program. It ends when its input does.
pub(crate) struct Embree {
    child: Child,
    questions: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Embree {
    /// Starts `program` and gives it the mesh and the rays.
    pub(crate) fn start(program: &Path, mesh: &Mesh, sets: &[RaySet]) -> io::Result<Embree> {
        let mut child = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let missing = || io::Error::other("no pipe");
        let mut questions = child.stdin.take().ok_or_else(missing)?;
        let answers = BufReader::new(child.stdout.take().ok_or_else(missing)?);
        write_data(&mut questions, mesh, sets)?;
        Ok(Embree {
            child,
            questions: Some(questions),
            answers,
        })
    }

    /// Processor seconds for all rays of set number `set`, and how many hit.
    pub(crate) fn run(
        &mut self,
        robust: bool,
        set: usize,
        query: Query,
    ) -> io::Result<(f64, usize)> {
        let ended = || io::Error::other("the program ended");
        let questions = self.questions.as_mut().ok_or_else(ended)?;
        let any = query == Query::Any;
        writeln!(questions, "{} {set} {}", u8::from(robust), u8::from(any))?;
        let mut answer = String::new();
        self.answers.read_line(&mut answer)?;
        let mut words = answer.split_whitespace();
        let seconds = words.next().and_then(|word| word.parse().ok());
        let hits = words.next().and_then(|word| word.parse().ok());
        seconds.zip(hits).ok_or_else(ended)
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        self.questions = None;
        let _ = self.child.wait();
    }
}

/// Counts and numbers in the machine's byte order: vertices, triangles, then the sets of rays
/// (origin, direction, length).
fn write_data(out: impl Write, mesh: &Mesh, sets: &[RaySet]) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let count = |n: usize| (n as u32).to_ne_bytes();
    out.write_all(&count(mesh.data.positions.len()))?;
    for p in &mesh.data.positions {
        for x in p.as_vec3().to_array() {
            out.write_all(&x.to_ne_bytes())?;
        }
    }
    out.write_all(&count(mesh.data.indices.len()))?;
    for i in mesh.data.indices.iter().flatten() {
        out.write_all(&i.to_ne_bytes())?;
    }
    out.write_all(&count(sets.len()))?;
    for set in sets {
        out.write_all(&count(set.rays.len()))?;
        for ray in &set.rays {
            let numbers = [ray.o.to_array(), ray.d.to_array()].concat();
            for x in numbers.iter().chain([&ray.t_max]) {
                out.write_all(&x.to_ne_bytes())?;
            }
        }
    }
    out.flush()
}
