//! Messages as they are printed, to the letter.

use crate::{Folder, read, read_file};

#[test]
fn messages_of_several_files_exactly() {
    let folder = Folder::new(&[
        (
            "main.pbrt",
            "Camera \"realistic\" \"string lensfile\" \"lens.dat\"\nInclude \"parts/ball.pbrt\"\nShpae \"disk\"\n",
        ),
        (
            "parts/ball.pbrt",
            "# one ball\r\nShape \"sphere\"\r\n\t\"flaot radius\" [ 2 ]\r\n\t\"float zmin\" [ 1,5 ]",
        ),
    ]);
    let expected = r#"error: unknown parameter type `flaot`
 --> FOLDER/parts/ball.pbrt:3:2
  |
3 |     "flaot radius" [ 2 ]
  |     ^^^^^^^^^^^^^^ parameter `radius` is ignored
  |
  = note: included from FOLDER/main.pbrt:2:1
  = help: did you mean `float`?

warning: a number is followed by something else
 --> FOLDER/parts/ball.pbrt:4:18
  |
4 |     "float zmin" [ 1,5 ]
  |                     ^^ ignored, as pbrt-v3 does
  |
  = note: included from FOLDER/main.pbrt:2:1
  = help: numbers are separated by blanks

error: expected a directive, found `Shpae`
 --> FOLDER/main.pbrt:3:1
  |
3 | Shpae "disk"
  | ^^^^^ no directive has this name
  |
  = help: did you mean `Shape`?

"#;
    assert_eq!(folder.text(&read_file(&folder.path("main.pbrt"))), expected);
}

#[test]
fn the_excerpt_of_an_endless_line_is_short() {
    let scene = format!(
        "Shape \"mesh\" \"point P\" [{} 7,7 {}]",
        "1 2 3 ".repeat(300_000),
        "4 5 6 ".repeat(300_000)
    );
    let expected = r#"warning: a number is followed by something else
 --> scene.pbrt:1:1800027
  |
1 | …3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3  7,7 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6…
  |                                          ^^ ignored, as pbrt-v3 does
  |
  = help: numbers are separated by blanks

"#;
    let text = read(scene).text;
    assert!(text.starts_with(expected), "{text}");
}

#[test]
fn a_message_at_the_end_of_the_file() {
    let expected = r#"error: `Translate` needs three numbers: x y z, found the end of the file
 --> scene.pbrt:1:14
  |
1 | Translate 1 2
  |              ^ expected three numbers: x y z

"#;
    assert_eq!(read("Translate 1 2").text, expected);
}
