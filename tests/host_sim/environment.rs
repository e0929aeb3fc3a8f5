//! Sessions with a C compiler, live input or a terminal, which `tests/cases` cannot have; and each command's help.

use crate::missing::has_c_compiler;
use crate::program::{PROGRAM, host_sim, utf8};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};

#[test]
fn a_c_array_compiles() {
    if !has_c_compiler("a_c_array_compiles") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (header, source) = (folder.path().join("my clip.h"), folder.path().join("main.c"));
    assert_eq!(host_sim(&["convert", "periodic", "-o", utf8(&header), "--frames", "1..3"]).code, Some(0));
    let text = "#include \"my clip.h\"\nint main(void) { return MY_CLIP_FRAMES == 3 && sizeof my_clip == 3 * MY_CLIP_WIDTH * MY_CLIP_HEIGHT ? 0 : 1; }\n";
    fs::write(&source, text).unwrap();
    let program = folder.path().join("program");
    let compiler =
        Command::new("cc").args(["-std=c99", "-Wall", "-Werror", "-pedantic", "-o"]).args([&program, &source]).status();
    assert!(compiler.unwrap().success());
    assert!(Command::new(program).status().unwrap().success());
    // These recordings are named like keywords and header names of C.
    for name in ["int", "default", "size", "time", "linux"] {
        let header = folder.path().join(format!("{name}.h"));
        assert_eq!(host_sim(&["convert", "periodic", "-o", utf8(&header), "--frames", "1..1"]).code, Some(0));
        let text = format!(
            "#include <limits.h>\n#include <stdint.h>\n#include <time.h>\n#include \"{name}.h\"\nconst unsigned char *first = frames_{name}[0];\n"
        );
        fs::write(&source, text).unwrap();
        let checked = Command::new("cc").args(["-Wall", "-Werror", "-fsyntax-only"]).arg(&source).status();
        assert!(checked.unwrap().success(), "{name}");
    }
}

#[test]
fn every_frame_is_answered_as_it_comes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("live.y4m");
    assert_eq!(host_sim(&["convert", "synthetic", "-o", utf8(&file), "--frames", "1..6"]).code, Some(0));
    let expected = host_sim(&["track", "synthetic", "--frames", "1..6"]).out;
    let bytes = fs::read(&file).unwrap();
    let start = bytes.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    let frame = (bytes.len() - start) / 6;

    let [x, y, right, bottom] = expected
        .lines()
        .next()
        .unwrap()
        .split(',')
        .map(|number| number.parse::<i32>().unwrap())
        .collect::<Vec<_>>()[..]
    else {
        panic!()
    };
    let init = format!("{x},{y},{},{}", right - x, bottom - y);
    let mut live = Command::new(PROGRAM);
    let mut live =
        live.args(["track", "-", "--init", &init]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let (mut to, mut from) = (live.stdin.take().unwrap(), BufReader::new(live.stdout.take().unwrap()));
    to.write_all(&bytes[..start]).unwrap();
    for (number, expected) in expected.lines().enumerate() {
        to.write_all(&bytes[start + number * frame..][..frame]).unwrap();
        to.flush().unwrap();
        let mut line = String::new();
        // Sends the next frame only after the answer: if host-sim buffered its answers, this would wait forever.
        from.read_line(&mut line).unwrap();
        assert_eq!(line.trim_end(), expected);
    }
    drop(to);
    let mut rest = String::new();
    from.read_to_string(&mut rest).unwrap();
    assert_eq!((rest.as_str(), live.wait().unwrap().code()), ("", Some(0)));

    let frames = fs::File::open(&file).unwrap();
    let refused = Command::new(PROGRAM).args(["track", "-"]).stdin(frames).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("standard input: no initial box: give --init"));
}

#[cfg(target_os = "linux")]
#[test]
fn on_a_terminal_a_film_comes_with_what_happens_instead_of_numbers() {
    if !crate::missing::has("on_a_terminal_a_film_comes_with_what_happens_instead_of_numbers", "script", &["--version"])
    {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let film = folder.path().join("film");
    let line = format!("'{PROGRAM}' track synthetic --frames ..20 --video '{}'", film.display());
    let output = Command::new("script").args(["-qec", &line, "/dev/null"]).stdin(Stdio::null()).output();
    let said = String::from_utf8_lossy(&output.unwrap().stdout).into_owned();
    assert!(said.contains("locked at frame 1") && said.contains(&format!("{}: 20 frames", film.display())), "{said}");
    assert!(said.contains("tracking 20") && said.contains("20 frames, ") && !said.contains("36,24,60,52"), "{said}");
    assert_eq!(fs::read_dir(&film).unwrap().count(), 20);
}

#[test]
fn each_command_has_an_example() {
    let help = host_sim(&["--help"]).out;
    let commands = help.split("Commands:").nth(1).unwrap().split("\n\n").next().unwrap().to_owned();
    let commands: Vec<&str> = commands.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.len() >= 7 && commands.contains(&"replay"), "{commands:?}");
    for command in commands.iter().filter(|&&command| command != "help") {
        let help = host_sim(&[command, "--help"]);
        assert!(help.out.contains("Example") && help.out.contains(&format!("host-sim {command}")), "{command}");
    }
}

#[test]
fn no_color_is_heeded() {
    let help = |variables: &[(&str, &str)]| {
        let mut command = Command::new(PROGRAM);
        command.env_remove("NO_COLOR").env("CLICOLOR_FORCE", "1").envs(variables.iter().copied());
        command.args(["track", "--help"]).output().unwrap().stdout
    };
    let escapes = |text: Vec<u8>| text.contains(&0x1B);
    assert!(escapes(help(&[])), "the test can fail");
    assert!(!escapes(help(&[("NO_COLOR", "1")])));
}
