//! Estimate of processor cycles, from a QEMU trace and the instruction timings of the manual.
//!
//! QEMU counts instructions but has no timing model. Its log (`-d in_asm,exec,nochain`) contains the
//! disassembly of each block of instructions once, and the address of each block entered. This gives
//! every instruction of a step, and whether each branch was taken. Cycles per instruction are from the
//! Cortex-M4 Technical Reference Manual (ARM DDI 0439B, 3.3.1 and 7.2.3):
//!
//! | instruction | cycles |
//! |---|---|
//! | data processing, multiplication (with `umull` and `mla`), moves to and from the FPU, `vadd`, `vmul`, `vcvt`, `vcmp` | 1 |
//! | `vmla` and the other fused and chained forms | 3 |
//! | `vdiv`, `vsqrt` | 14 |
//! | `sdiv`, `udiv`: 2 to 12 | 7 |
//! | load (`ldr`, `vldr`): 2, or 1 directly after another load or store | 1 or 2 |
//! | store (`str`, through the write buffer) | 1 |
//! | `vstr`: 2, or 1 directly after another load or store | 1 or 2 |
//! | N registers (`ldm`, `push`, `vpop`, `ldrd` …) | 1 + N |
//! | branch taken: 1 + P, pipeline refill P from 1 to 3 | 1 + 2 |
//! | branch not taken, `it`, instruction of a false condition | 1 |
//!
//! P = 2 gives the estimate; P = 1 and 3 give its range. Not included: flash wait states, which the
//! STM32F405's accelerator hides only in straight code and in its cache of 1 KiB (a miss costs five
//! cycles at 168 MHz); the stall of an FPU instruction that needs the previous result; interrupts. The
//! result is a lower estimate, not a measurement.

use anyhow::{Result, ensure};
use std::collections::HashMap;
use std::io::BufRead;

/// Pipeline refill after a branch, cycles: least, assumed, most.
const REFILL: [u32; 3] = [1, 2, 3];

/// Cost of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Cost {
    /// Cycles without pipeline refill.
    cycles: u32,
    /// True if it is a load or store that overlaps the next one.
    is_access: bool,
}

/// Cycles of executed code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cycles {
    /// Cycles by pipeline refill: least, assumed, most.
    pub of_refill: [u32; 3],
    /// Number of instructions.
    pub instructions: u32,
}

/// A translated block of instructions.
#[derive(Debug, Clone, Default)]
struct Block {
    /// Address after each instruction, and its cost.
    instructions: Vec<(u32, Cost)>,
    /// Branch target of the last instruction.
    target: Option<u32>,
}

/// Cost of an instruction in a disassembly, such as `vmul.f32 s0, s0, s1`.
fn cost(mnemonic: &str, operands: &str) -> Cost {
    let name = mnemonic.split('.').next().unwrap_or(mnemonic);
    let cost = |cycles| Cost { cycles, is_access: false };
    let access = |cycles| Cost { cycles, is_access: true };
    let starts = |kinds: &[&str]| kinds.iter().any(|kind| name.starts_with(kind));
    if starts(&["vdiv", "vsqrt"]) {
        cost(14)
    } else if starts(&["vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnma", "vfnms"]) {
        cost(3)
    } else if starts(&["sdiv", "udiv"]) {
        cost(7)
    } else if starts(&["ldm", "stm", "vldm", "vstm", "push", "pop", "vpush", "vpop"]) {
        cost(1 + registers(operands))
    } else if starts(&["ldrd", "strd"]) {
        cost(3)
    } else if starts(&["ldr", "vldr", "vstr"]) {
        access(2)
    } else if starts(&["str"]) {
        access(1)
    } else {
        cost(1)
    }
}

/// Number of words in a register list, such as `{r4, r5}` or `{s16-s19}`; a double counts twice.
fn registers(operands: &str) -> u32 {
    let list = operands.split(['{', '}']).nth(1).unwrap_or_default();
    let number = |register: &str| register.trim().get(1..)?.parse::<u32>().ok();
    list.split(',')
        .map(|part| {
            let words = if part.trim().starts_with('d') { 2 } else { 1 };
            let range = part.split_once('-').and_then(|(a, b)| Some((number(a)?, number(b)?)));
            words * range.map_or(1, |(first, last)| last.saturating_sub(first) + 1)
        })
        .sum()
}

/// Parser of a QEMU trace: cycles of every call of some functions.
pub struct Trace {
    /// Entry addresses of the functions.
    entries: Vec<u32>,
    blocks: HashMap<u32, Block>,
    /// Block whose disassembly is being read.
    reading: Option<(u32, Block)>,
    /// Block being executed.
    running: Option<u32>,
    /// Return address of the call in progress.
    returns_to: Option<u32>,
    now: Cycles,
    was_access: bool,
    /// Cycles of each call, in order.
    pub calls: Vec<Cycles>,
}

impl Trace {
    /// A parser of calls of the functions at these addresses.
    pub fn new(entries: Vec<u32>) -> Self {
        Self {
            entries,
            blocks: HashMap::new(),
            reading: None,
            running: None,
            returns_to: None,
            now: Cycles::default(),
            was_access: false,
            calls: Vec::new(),
        }
    }

    /// Reads a trace to its end.
    ///
    /// # Errors
    /// The trace is unreadable, or contains no call of the functions.
    pub fn read(&mut self, mut log: impl BufRead) -> Result<()> {
        let mut line = Vec::new();
        while log.read_until(b'\n', &mut line)? > 0 {
            if let Ok(text) = std::str::from_utf8(&line) {
                self.take(text.trim_end());
            }
            line.clear();
        }
        ensure!(
            !self.calls.is_empty(),
            "the QEMU trace contains no call of the counted steps: are step_fast and step_covariance inlined?"
        );
        Ok(())
    }

    fn take(&mut self, line: &str) {
        if let Some(entered) = line.strip_prefix("Trace ") {
            self.close_text();
            let address = entered.split('/').nth(1).and_then(hexadecimal);
            if let Some(address) = address {
                self.enter(address);
            }
        } else if line.starts_with("IN:") {
            self.close_text();
        } else if let Some(text) = line.strip_prefix("0x") {
            self.take_text(text);
        }
    }

    /// Reads a line of disassembly, such as `08000254:  f240 0127  movw     r1, #0x27`.
    fn take_text(&mut self, text: &str) {
        let Some((address, rest)) = text.split_once(':') else { return };
        let Some(address) = hexadecimal(address) else { return };
        let is_code = |word: &&str| word.len() == 4 && hexadecimal(word).is_some();
        let code = rest.split_whitespace().take_while(is_code).count().min(2);
        let mut words = rest.split_whitespace().skip(code);
        let mnemonic = words.next().unwrap_or_default();
        let operands: Vec<&str> = words.collect();
        let (_, block) = self.reading.get_or_insert_with(|| (address, Block::default()));
        let operands = operands.join(" ");
        block.instructions.push((address + 2 * code as u32, cost(mnemonic, &operands)));
        let is_branch = mnemonic.starts_with('b') || mnemonic.starts_with("cb");
        let target = operands.rsplit("#0x").next().filter(|_| is_branch);
        block.target = target.and_then(hexadecimal);
    }

    fn close_text(&mut self) {
        let Some((start, block)) = self.reading.take() else { return };
        // QEMU translates a block again after leaving it early; the complete block stays in use.
        let known = self.blocks.entry(start).or_default();
        if known.instructions.len() < block.instructions.len() {
            *known = block;
        }
    }

    /// Execution reaches `address`, which completes the block before.
    fn enter(&mut self, address: u32) {
        let last = self.running.replace(address);
        let end = last.and_then(|last| self.run(last, address));
        if self.returns_to == Some(address) {
            self.returns_to = None;
            self.calls.push(self.now);
        }
        if self.returns_to.is_none() && self.entries.contains(&address) {
            self.returns_to = end;
            self.now = Cycles::default();
            self.was_access = false;
        }
    }

    /// Counts a block that continues at `next`. Returns the address after the block.
    fn run(&mut self, start: u32, next: u32) -> Option<u32> {
        let block = self.blocks.get(&start)?;
        let end = block.instructions.last().map_or(start, |(after, _)| *after);
        // A block left before its end continues in its middle; so does a loop, by a branch.
        let is_taken = block.target == Some(next);
        if self.returns_to.is_none() {
            return Some(end);
        }
        let mut cycles = 0;
        for (after, cost) in &block.instructions {
            let overlaps = self.was_access && cost.is_access;
            cycles += if overlaps { 1 } else { cost.cycles };
            self.was_access = cost.is_access;
            self.now.instructions += 1;
            if *after == next && !is_taken {
                break;
            }
        }
        let is_straight = !is_taken && block.instructions.iter().any(|(after, _)| *after == next);
        for (sum, refill) in self.now.of_refill.iter_mut().zip(REFILL) {
            *sum += cycles + if is_straight { 0 } else { refill };
        }
        Some(end)
    }
}

fn hexadecimal(text: &str) -> Option<u32> {
    u32::from_str_radix(text, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycles(mnemonic: &str, operands: &str) -> u32 {
        cost(mnemonic, operands).cycles
    }

    #[test]
    fn instructions_cost_what_the_manual_says() {
        assert_eq!(cycles("add.w", "r0, r1, r2"), 1);
        assert_eq!(cycles("umull", "r0, r1, r2, r3"), 1);
        assert_eq!(cycles("udiv", "r0, r1, r2"), 7);
        assert_eq!(cycles("vmul.f32", "s0, s1, s2"), 1);
        assert_eq!(cycles("vmla.f32", "s0, s1, s2"), 3);
        assert_eq!(cycles("vdiv.f32", "s0, s1, s2"), 14);
        assert_eq!(cycles("vsqrt.f32", "s0, s1"), 14);
        assert_eq!(cycles("ldr.w", "r0, [r1, #4]"), 2);
        assert_eq!(cycles("str", "r0, [r1]"), 1);
        assert_eq!(cycles("ldrd", "r0, r1, [r2]"), 3);
        assert_eq!(cycles("push.w", "{r4, r5, r8, lr}"), 5);
        assert_eq!(cycles("vpush", "{d8, d9}"), 5);
        assert_eq!(cycles("vldmia", "r0!, {s0-s3}"), 5);
    }

    /// A leaf function of six instructions with one loop.
    const LOG: &str = "\
IN: caller
0x08000100:  f000 f87e  bl       #0x8000200

Trace 0: 0x7f [00800408/08000100/00000110/ff020200] caller
IN: step
0x08000200:  b510       push     {r4, lr}
0x08000202:  ed90 0a00  vldr     s0, [r0]
0x08000206:  ed90 1a01  vldr     s2, [r0, #4]
0x0800020a:  ee80 0a01  vdiv.f32 s0, s0, s2
0x0800020e:  d1f7       bne      #0x8000200

Trace 0: 0x7f [00800408/08000200/00000110/ff020200] step
Trace 0: 0x7f [00800408/08000200/00000110/ff020200] step
IN: step
0x08000210:  bd10       pop      {r4, pc}

Trace 0: 0x7f [00800408/08000210/00000110/ff020200] step
IN: caller
0x08000104:  bf00       nop

Trace 0: 0x7f [00800408/08000104/00000110/ff020200] caller
";

    #[test]
    fn known_sequence_takes_the_cycles_of_the_manual() {
        let mut trace = Trace::new(vec![0x0800_0200]);
        trace.read(LOG.as_bytes()).unwrap();
        // push 3, vldr 2, overlapping vldr 1, vdiv 14, bne 1: 21, twice; pop 3. Two refills.
        let expected = Cycles { of_refill: [45 + 2, 45 + 4, 45 + 6], instructions: 11 };
        assert_eq!(trace.calls, [expected]);
    }

    /// A loop that starts in the middle of the block that first reaches it.
    const LOOP: &str = "\
IN: caller
0x08000100:  f000 f87e  bl       #0x8000200

Trace 0: 0x7f [0/08000100/0/0] caller
IN: step
0x08000200:  2003       movs     r0, #3
0x08000202:  1e40       subs     r0, r0, #1
0x08000204:  d1fd       bne      #0x8000202

Trace 0: 0x7f [0/08000200/0/0] step
IN: step
0x08000202:  1e40       subs     r0, r0, #1
0x08000204:  d1fd       bne      #0x8000202

Trace 0: 0x7f [0/08000202/0/0] step
Trace 0: 0x7f [0/08000202/0/0] step
IN: step
0x08000206:  4770       bx       lr

Trace 0: 0x7f [0/08000206/0/0] step
IN: caller
0x08000104:  bf00       nop

Trace 0: 0x7f [0/08000104/0/0] caller
";

    #[test]
    fn every_iteration_of_a_loop_counts() {
        let mut trace = Trace::new(vec![0x0800_0200]);
        trace.read(LOOP.as_bytes()).unwrap();
        // movs; three times subs and bne, twice taken; bx.
        let expected = Cycles { of_refill: [8 + 3, 8 + 6, 8 + 9], instructions: 8 };
        assert_eq!(trace.calls, [expected]);
    }

    #[test]
    fn trace_without_the_function_is_an_error() {
        assert!(Trace::new(vec![0x0800_0300]).read(LOG.as_bytes()).is_err());
    }
}
