//! Shell lines of a page as commands.

/// Runs of a campaign in this test, at most.
const MOST_RUNS: u64 = 4;

/// A command that this test executes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// `cargo run --release -p host-sim -- ARGUMENTS`.
    HostSim(Vec<String>),
    /// `cp FROM TO`.
    Copy { from: String, to: String },
}

impl Command {
    /// Recognises a command that can be executed here.
    pub fn parse(line: &str) -> Result<Self, String> {
        if line.contains(['|', '<', '>', '&', ';', '$', '*', '"', '\'']) {
            return Err("needs a shell; precede the block with `<!-- not run: REASON -->`".into());
        }
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        if let Some(arguments) = host_sim_arguments(&words) {
            return Ok(Self::HostSim(arguments.to_vec()));
        }
        match &words[..] {
            [program, from, to] if program == "cp" => {
                Ok(Self::Copy { from: from.clone(), to: to.clone() })
            }
            _ => {
                Err("is not executed here; precede the block with `<!-- not run: REASON -->`"
                    .into())
            }
        }
    }
}

/// The words after `cargo run --release -p host-sim --`.
pub fn host_sim_arguments(words: &[String]) -> Option<&[String]> {
    let start = ["cargo", "run", "--release", "-p", "host-sim", "--"];
    (words.len() > start.len() && words.iter().zip(start).all(|(word, start)| word == start))
        .then(|| &words[start.len()..])
}

/// The same arguments with few runs.
pub fn with_few_runs(arguments: &[String]) -> Vec<String> {
    let mut arguments = arguments.to_vec();
    let runs = arguments.iter().position(|word| word == "--runs");
    match runs {
        Some(at) => {
            let asked: u64 = arguments[at + 1].parse().unwrap();
            arguments[at + 1] = asked.min(MOST_RUNS).to_string();
        }
        None if arguments[0] == "tables" => arguments.extend(["--runs".into(), "1".into()]),
        None => {}
    }
    arguments
}

/// The commands of a block: a line each, comments removed, continued lines joined.
pub fn lines(text: &str) -> Vec<String> {
    let joined = text.replace("\\\n", " ");
    let without_comment =
        |line: &str| line.split(" #").next().unwrap_or_default().trim().to_owned();
    let is_command = |line: &String| !line.is_empty() && !line.starts_with('#');
    joined.lines().map(without_comment).filter(is_command).collect()
}

/// The words of each program of a line: of a pipe several, redirections left out.
pub fn word_lists(line: &str) -> Vec<Vec<String>> {
    let words = |part: &str| {
        let mut words: Vec<String> = Vec::new();
        let mut is_file = false;
        for word in part.split_whitespace() {
            let is_redirection = word.starts_with(['>', '<']);
            if !is_redirection && !is_file {
                words.push(word.to_owned());
            }
            is_file = is_redirection && word.len() == 1;
        }
        words
    };
    line.split(['|', '&']).map(words).filter(|words| !words.is_empty()).collect()
}

#[test]
fn shell_lines_become_words() {
    let block = "a b | c > d # comment\n# another\n\ne \\\n  f &\n";
    assert_eq!(lines(block), ["a b | c > d", "e    f &"]);
    assert_eq!(word_lists("a b | c > d"), [vec!["a", "b"], vec!["c"]]);
    assert_eq!(word_lists("e    f &"), [["e", "f"]]);
}

#[test]
fn campaigns_are_shortened() {
    let of = |line: &str| {
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        with_few_runs(&words).join(" ")
    };
    assert_eq!(of("mc x --runs 10000"), "mc x --runs 4");
    assert_eq!(of("tables --out papers"), "tables --out papers --runs 1");
    assert_eq!(of("run x"), "run x");
}
