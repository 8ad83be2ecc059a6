//! The documentation as readers find it: every page is listed, every link leads somewhere, and sentences can be read.

use std::fs;
use std::path::{Path, PathBuf};

use crate::sources::rust_files;

/// Longest sentence of every page of the documentation (words).
const WORDS: usize = 25;

fn docs() -> PathBuf {
    xtask::root().join("docs")
}

/// Returns the pages below a folder.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(pages(&path));
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Returns the targets of a page's links and pictures, outside of code blocks.
fn links(text: &str) -> Vec<String> {
    let mut targets = Vec::new();
    let mut in_code = false;
    for line in text.lines() {
        in_code ^= line.starts_with("```");
        if in_code {
            continue;
        }
        for part in line.split("](").skip(1) {
            targets.extend(part.split_once(')').map(|(target, _)| target.to_string()));
        }
    }
    targets
}

/// Returns the anchors of a page's headings, as Markdown renderers make them.
fn anchors(text: &str) -> Vec<String> {
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    headings
        .map(|heading| {
            let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            kept.collect::<String>().to_lowercase().replace(' ', "-")
        })
        .collect()
}

#[test]
fn the_site_lists_every_page_and_only_pages_that_exist() {
    let summary = fs::read_to_string(docs().join("SUMMARY.md")).unwrap();
    let listed: Vec<String> = links(&summary);
    for page in pages(&docs()) {
        let name = page.strip_prefix(docs()).unwrap().display().to_string();
        assert!(name == "SUMMARY.md" || listed.contains(&name), "{name} is not in docs/SUMMARY.md");
    }
    for (at, name) in listed.iter().enumerate() {
        assert!(!listed[..at].contains(name), "docs/SUMMARY.md: {name} is listed twice");
        // Written by the program when the site is built.
        assert!(name == "commands.md" || docs().join(name).is_file(), "docs/SUMMARY.md: {name} is not there");
    }
}

#[test]
fn every_link_leads_somewhere() {
    let root = xtask::root();
    let own = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|name| root.join(name));
    let mut broken = Vec::new();
    for page in pages(&docs()).into_iter().chain(own) {
        let text = fs::read_to_string(&page).unwrap();
        for link in links(&text) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            if link.contains("://") || file == "commands.md" {
                continue;
            }
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            let is_there = target.exists();
            let has_anchor = || anchors(&fs::read_to_string(&target).unwrap_or_default()).iter().any(|a| a == anchor);
            if !is_there || (!anchor.is_empty() && !has_anchor()) {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn every_guide_says_how_long_its_steps_take() {
    let summary = fs::read_to_string(docs().join("SUMMARY.md")).unwrap();
    let guides = links(summary.split("\n# ").find(|part| part.starts_with("Guides")).unwrap());
    assert!(guides.len() >= 6, "{guides:?}");
    for guide in guides {
        let text = fs::read_to_string(docs().join(&guide)).unwrap();
        assert!(text.lines().take(4).any(|line| line.starts_with("**Time:** ")), "{guide}: expected '**Time:** ...'");
    }
}

#[test]
fn the_site_has_every_page_that_its_pages_link_to() {
    let site = tempfile::tempdir().unwrap();
    xtask::docs::collect(&xtask::root(), site.path()).unwrap();
    let mut broken = Vec::new();
    for page in pages(site.path()) {
        for link in links(&fs::read_to_string(&page).unwrap()) {
            let file = link.split('#').next().unwrap_or_default();
            // Source files are no pages, and the command reference comes from the program.
            let is_page = file.ends_with(".md") && file != "commands.md" && !link.contains("://");
            if is_page && !page.parent().unwrap().join(file).exists() {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// Returns the sentences of a page's paragraphs and lists; tables, code and headings have none.
fn sentences(text: &str) -> Vec<String> {
    let (mut paragraphs, mut in_code) = (vec![String::new()], false);
    for line in text.lines() {
        let trimmed = line.trim();
        if trimmed.starts_with("```") {
            in_code = !in_code;
            paragraphs.push(String::new());
        } else if in_code || trimmed.is_empty() || trimmed.starts_with(['#', '|', '!']) {
            paragraphs.push(String::new());
        } else {
            if trimmed.starts_with("- ")
                || trimmed.starts_with("* ")
                || trimmed.split_once(". ").is_some_and(|(n, _)| n.parse::<u8>().is_ok())
            {
                paragraphs.push(String::new());
            }
            let paragraph = paragraphs.last_mut().unwrap();
            paragraph.push_str(trimmed);
            paragraph.push(' ');
        }
    }
    paragraphs.iter().flat_map(|paragraph| split(paragraph)).collect()
}

/// Splits a paragraph after the words that end a sentence.
fn split(paragraph: &str) -> Vec<String> {
    let mut found = vec![Vec::new()];
    for word in paragraph.split_whitespace() {
        found.last_mut().unwrap().push(word);
        if word.trim_end_matches(['*', ')', '"', '`']).ends_with(['.', '?', '!', ':']) {
            found.push(Vec::new());
        }
    }
    found.into_iter().filter(|words| !words.is_empty()).map(|words| words.join(" ")).collect()
}

#[test]
fn sentences_are_split_at_their_ends() {
    let text =
        "# Title\n\nOne runs at 0.5 m. Two\nis here: three.\n\n- four\n- five\n\n| a | b |\n\n```sh\nno. text\n```\n";
    assert_eq!(sentences(text), ["One runs at 0.5 m.", "Two is here:", "three.", "- four", "- five"]);
}

/// Words that begin a question, and no other sentence.
const QUESTIONS: [&str; 5] = ["What", "How", "Where", "Whether", "Who"];

/// Returns whether a word is no number and no symbol of a formula.
fn is_word(word: &str) -> bool {
    ["a", "A", "I"].contains(&word) || word.as_bytes().windows(2).any(|pair| pair.iter().all(u8::is_ascii_alphabetic))
}

/// Returns the sentences that are too long, or that begin like a question, with the name of their page.
fn hard_sentences(page: &Path, text: &str) -> Vec<String> {
    let is_hard = |sentence: &String| {
        let first = sentence.split_whitespace().next().unwrap_or_default();
        let is_question = QUESTIONS.contains(&first) && !sentence.ends_with('?');
        is_question || sentence.split_whitespace().filter(|word| is_word(word)).count() > WORDS
    };
    sentences(text).into_iter().filter(is_hard).map(|sentence| format!("{}: {sentence}", page.display())).collect()
}

#[test]
fn sentences_are_short_and_begin_with_their_subject() {
    let mut wrong = Vec::new();
    for page in pages(&docs()).into_iter().chain(["README.md", "ARCHITECTURE.md"].map(|name| xtask::root().join(name)))
    {
        wrong.extend(hard_sentences(&page, &fs::read_to_string(&page).unwrap()));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Returns the sentences of a file's doc comments that are hard to read.
fn hard_comments(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    let comment = |line: &str| {
        let line = line.trim_start();
        line.strip_prefix("//!").or(line.strip_prefix("///")).unwrap_or_default().to_string()
    };
    // A line of code is empty here, and ends a paragraph.
    hard_sentences(file, &text.lines().map(comment).collect::<Vec<_>>().join("\n"))
}

#[test]
fn doc_comments_are_short_and_begin_with_their_subject() {
    let folders = fs::read_dir(xtask::root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let folders = folders.chain(["thesis", "xtask"].map(|name| xtask::root().join(name)));
    let files = folders.map(|folder| folder.join("src")).filter(|source| source.is_dir());
    let wrong: Vec<String> =
        files.flat_map(|source| rust_files(&source)).flat_map(|file| hard_comments(&file)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}
