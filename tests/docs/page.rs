//! A Markdown page: its links, its code spans, and its fenced blocks with their roles.

use std::fs;
use std::path::{Path, PathBuf};

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};
use tests::program::repository;

/// Folders of pages.
const FOLDERS: [&str; 3] = ["fsw-core/docs", "fsw-target/docs", "host-sim/docs"];
/// Pages elsewhere.
const SINGLE: [&str; 3] = ["README.md", "fsw-core/README.md", "fsw-target/src/link/link.md"];

/// Purpose of a fenced block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Role {
    /// Its commands are executed.
    Run,
    /// Its commands are checked.
    NotRun { reason: String },
    /// It shows the output of a command.
    OutputOf { command: String },
}

/// A fenced block.
#[derive(Clone, Debug)]
pub struct Block {
    pub language: String,
    pub role: Role,
    pub text: String,
}

/// A page.
#[derive(Debug)]
pub struct Page {
    /// Path from the root of the repository.
    pub name: String,
    pub links: Vec<String>,
    pub code: Vec<String>,
    pub blocks: Vec<Block>,
}

impl Page {
    /// Every page of the repository.
    pub fn all() -> Vec<Self> {
        let in_folder = |folder: &&str| fs::read_dir(repository().join(folder)).unwrap();
        let paths = FOLDERS.iter().flat_map(in_folder).map(|entry| entry.unwrap().path());
        let paths = paths.filter(|path| path.extension().is_some_and(|end| end == "md"));
        let single = SINGLE.iter().map(|name| repository().join(name));
        single.chain(paths).map(|path| Self::read(&path)).collect()
    }

    /// Reads a page.
    pub fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap();
        let name = path.strip_prefix(repository()).unwrap().to_str().unwrap().to_owned();
        let mut page = Self { name, links: Vec::new(), code: Vec::new(), blocks: Vec::new() };
        // The comment that stands directly before what comes next.
        let mut comment = String::new();
        let mut block: Option<Block> = None;
        for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::HtmlBlock) | Event::End(TagEnd::HtmlBlock) => continue,
                Event::Html(html) => {
                    comment = html.trim().to_owned();
                    continue;
                }
                Event::Start(Tag::CodeBlock(kind)) => {
                    let (language, role) = (language(&kind), role(&comment));
                    block = Some(Block { language, role, text: String::new() });
                }
                Event::End(TagEnd::CodeBlock) => page.blocks.extend(block.take()),
                Event::Text(text) => {
                    if let Some(block) = &mut block {
                        block.text.push_str(&text);
                    }
                }
                Event::Start(Tag::Link { dest_url, .. }) => page.links.push(dest_url.to_string()),
                Event::Code(code) => page.code.push(code.to_string()),
                _ => {}
            }
            comment.clear();
        }
        page
    }

    /// The page's folder.
    pub fn folder(&self) -> PathBuf {
        repository().join(&self.name).parent().unwrap().to_owned()
    }

    /// Its blocks of a language.
    pub fn blocks_of(&self, language: &str) -> impl Iterator<Item = &Block> {
        self.blocks.iter().filter(move |block| block.language == language)
    }
}

fn language(kind: &CodeBlockKind<'_>) -> String {
    match kind {
        CodeBlockKind::Fenced(info) => info.to_string(),
        CodeBlockKind::Indented => String::new(),
    }
}

/// The role that a comment before a block gives it.
fn role(comment: &str) -> Role {
    let text = comment.trim_start_matches("<!--").trim_end_matches("-->").trim();
    if let Some(reason) = text.strip_prefix("not run:") {
        Role::NotRun { reason: reason.trim().to_owned() }
    } else if let Some(command) = text.strip_prefix("output of:") {
        Role::OutputOf { command: command.trim().to_owned() }
    } else {
        Role::Run
    }
}
