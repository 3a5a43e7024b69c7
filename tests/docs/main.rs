//! README.md and the pages of the crates: their commands work, their outputs, tables, links and
//! paths are those of the repository.
//!
//! Convention for a fenced block:
//!
//! | block | meaning |
//! |---|---|
//! | `sh` | each command is executed, in a copy of the root folder, with few runs for a campaign |
//! | `sh` after `<!-- not run: REASON -->` | each command is checked: program, verb, flags, target |
//! | `text` after `<!-- output of: COMMAND -->` | the command is executed and its output compared |

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod command;
mod folder;
mod output;
mod page;
mod verification;
mod workspace;

use std::process::Command as Process;

use command::{Command, lines, word_lists};
use folder::Folder;
use page::{Page, Role};
use tests::program::{HostSim, repository};
use workspace::Workspace;

const HOST_SIM: &str = env!("CARGO_BIN_EXE_host-sim-for-tests");

fn host_sim() -> HostSim {
    HostSim::Built(HOST_SIM.into())
}

/// Runs `check` on each page, and fails with all complaints at once.
fn on_each_page(check: impl Fn(&Page) -> Vec<String>) {
    let pages = Page::all();
    assert!(pages.len() > 10, "only {} pages are found", pages.len());
    let complaints: Vec<String> = (pages.iter())
        .flat_map(|page| check(page).into_iter().map(|text| format!("{}: {text}", page.name)))
        .collect();
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

#[test]
fn commands_run() {
    on_each_page(|page| {
        let folder = Folder::like_the_repository();
        let commands = page.blocks_of("sh").filter(|block| block.role == Role::Run);
        let run = |line: String| {
            let result = Command::parse(&line).and_then(|command| folder.run(&command));
            result.err().map(|why| format!("`{line}`: {why}"))
        };
        commands.flat_map(|block| lines(&block.text)).filter_map(run).collect()
    });
}

#[test]
fn commands_that_cannot_run_here_exist() {
    let workspace = Workspace::load();
    on_each_page(|page| {
        let commands =
            page.blocks_of("sh").filter(|block| matches!(block.role, Role::NotRun { .. }));
        let check = |words: Vec<String>| {
            workspace.check(&words).err().map(|why| format!("`{}`: {why}", words.join(" ")))
        };
        let lists = commands.flat_map(|block| lines(&block.text));
        lists.flat_map(|line| word_lists(&line)).filter_map(check).collect()
    });
}

#[test]
fn a_block_that_does_not_run_gives_its_reason() {
    on_each_page(|page| {
        let reason = |role: &Role| match role {
            Role::NotRun { reason } => Some(reason.clone()),
            _ => None,
        };
        let reasons = page.blocks.iter().filter_map(|block| reason(&block.role));
        let short = reasons.filter(|reason| reason.split_whitespace().count() < 2);
        short.map(|reason| format!("`{reason}` is no reason")).collect()
    });
}

#[test]
fn outputs_are_those_of_the_commands() {
    on_each_page(|page| {
        let compare = |block: &page::Block| {
            let Role::OutputOf { command } = &block.role else { return None };
            let Command::HostSim(arguments) = Command::parse(command).unwrap() else {
                return Some(format!("`{command}`: only the output of host-sim is compared"));
            };
            let printed = host_sim().output(&arguments).unwrap();
            output::compare(&block.text, &printed)
                .err()
                .map(|why| format!("output of `{command}`: {why}"))
        };
        page.blocks.iter().filter_map(compare).collect()
    });
}

#[test]
fn every_promise_has_a_test_a_number_and_a_command() {
    let (tables, workspace) = (verification::tables(), Workspace::load());
    assert!(tables.len() > 5, "{} tables", tables.len());
    let complaints: Vec<String> =
        tables.iter().flat_map(|table| table.complaints(&workspace)).collect();
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

#[test]
fn links_lead_to_files() {
    on_each_page(|page| {
        let is_local = |link: &&String| !link.contains("://") && !link.starts_with('#');
        let target = |link: &String| page.folder().join(link.split('#').next().unwrap());
        let broken = page.links.iter().filter(is_local).filter(|link| !target(link).exists());
        broken.map(|link| format!("the link `{link}` leads nowhere")).collect()
    });
}

#[test]
fn paths_in_the_text_exist() {
    let folders = ["fsw-core/", "fsw-target/", "host-sim/", "tests/", ".cargo/", ".ci/"];
    on_each_page(|page| {
        let is_path = |code: &&String| {
            folders.iter().any(|folder| code.starts_with(folder)) && !code.contains(' ')
        };
        // A test is a path and a function.
        let path = |code: &str| code.split("::").next().unwrap_or_default().to_owned();
        let missing = |code: &&String| !repository().join(path(code)).exists();
        let missing = page.code.iter().filter(is_path).filter(missing);
        missing.map(|path| format!("`{path}` does not exist")).collect()
    });
}

#[test]
fn every_page_stands_in_the_index_of_its_folder() {
    on_each_page(|page| {
        let index = page.folder().join("index.md");
        if !index.exists() || page.name.ends_with("index.md") {
            return Vec::new();
        }
        let file = page.name.rsplit('/').next().unwrap();
        let index = Page::read(&index);
        let is_listed = index.links.iter().any(|link| link == file);
        (!is_listed).then(|| format!("is not in {}", index.name)).into_iter().collect()
    });
}

#[test]
fn every_index_stands_in_the_readme() {
    let readme = Page::read(&repository().join("README.md"));
    on_each_page(|page| {
        let is_index = page.name.ends_with("/index.md");
        let is_linked = readme.links.contains(&page.name);
        (is_index && !is_linked).then(|| "is not in README.md".to_owned()).into_iter().collect()
    });
}

#[test]
fn readme_is_short() {
    const MOST_WORDS: usize = 1200;
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let words = readme.split_whitespace().count();
    assert!(words <= MOST_WORDS, "{words} words");
}

/// Two runs of each campaign, and the cells of the pages that need no campaign.
#[test]
fn accuracy_tables_follow_the_list_of_campaigns() {
    let mut accuracy = Process::new(env!("CARGO_BIN_EXE_accuracy"));
    let output = accuracy.args(["--check", "--host-sim", HOST_SIM]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
