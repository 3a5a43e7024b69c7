//! Campaigns in shards under real schedulers: GNU parallel, and Slurm on loopback.
//!
//! A scheduler that is not installed is skipped with a printed reason. On Debian: `apt-get install parallel slurm-wlm`.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::TempDir;

const HOST_SIM: &str = env!("CARGO_BIN_EXE_host-sim-for-tests");
/// A campaign of a second.
const SHORT: [&str; 5] = ["mc", "cubesat-pyramid", "--runs", "700", "--estimator=joint-ekf"];
/// A campaign of seconds: a shard can be killed in mid-flight.
const LONG: [&str; 5] = ["mc", "stsat3-spin-up", "--runs", "560", "--seed=3"];
/// Longest wait for a scheduler.
const PATIENCE: Duration = Duration::from_secs(300);

fn is_installed(program: &str) -> bool {
    let found = Command::new("sh").args(["-c", &format!("command -v {program}")]).output();
    found.is_ok_and(|output| output.status.success())
}

fn succeed(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// The document of a campaign in this file, or in these.
fn merged(files: &[PathBuf]) -> Vec<u8> {
    succeed(Command::new(HOST_SIM).arg("merge").args(files).arg("--json")).stdout
}

/// The document of the campaign in one process.
fn of_one_process(campaign: &[&str], folder: &Path) -> Vec<u8> {
    let file = folder.join("one-process.parquet");
    succeed(Command::new(HOST_SIM).args(campaign).arg("--out").arg(&file));
    merged(&[file])
}

fn shards(folder: &Path, count: usize) -> Vec<PathBuf> {
    (1..=count).rev().map(|number| folder.join(format!("{number}.parquet"))).collect()
}

fn wait_until(what: &str, is_so: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < PATIENCE, "{what}: not within {PATIENCE:?}");
        sleep(Duration::from_millis(20));
    }
}

#[test]
fn gnu_parallel_gives_the_report_of_one_process() {
    if !is_installed("parallel") {
        println!("skipped: GNU parallel is not installed");
        return;
    }
    let folder = TempDir::new().unwrap();
    let expected = of_one_process(&SHORT, folder.path());
    for count in [7, 64] {
        let out = folder.path().join(count.to_string());
        fs::create_dir(&out).unwrap();
        let mut parallel = Command::new("parallel");
        parallel.env("RAYON_NUM_THREADS", "1").args(["--will-cite", "--halt", "now,fail=1"]);
        parallel.arg(HOST_SIM).args(SHORT).arg("--shard").arg(format!("{{}}/{count}"));
        parallel.arg("--out").arg(out.join("{}.parquet")).arg(":::");
        succeed(parallel.args((1..=count).map(|number| number.to_string())));
        assert!(merged(&shards(&out, count)) == expected, "{count} shards");
    }
}

/// Configuration of a Slurm on loopback; `path` is that of a file in its folder, `socket` that of munge.
fn configuration(path: &dyn Fn(&str) -> String, socket: &str) -> String {
    let host = String::from_utf8(succeed(Command::new("hostname").arg("-s")).stdout).unwrap();
    let host = host.trim();
    let listeners = [0, 0].map(|_| TcpListener::bind("127.0.0.1:0").unwrap());
    let [controller, node] = listeners.map(|port| port.local_addr().unwrap().port());
    let cores = std::thread::available_parallelism().unwrap();
    format!(
        "ClusterName=loopback\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser=root\nSlurmdUser=root\n\
         AuthType=auth/munge\nCredType=cred/munge\nAuthInfo=socket={socket}\nMpiDefault=none\n\
         ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n\
         SelectTypeParameters=CR_Core\nStateSaveLocation={}\nSlurmdSpoolDir={}\n\
         SlurmctldPidFile={}\nSlurmdPidFile={}\nSlurmctldPort={controller}\nSlurmdPort={node}\n\
         ReturnToService=2\nNodeName={host} NodeAddr=127.0.0.1 CPUs={cores} State=UNKNOWN\n\
         PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP\n",
        path("state"),
        path("spool"),
        path("slurmctld.pid"),
        path("slurmd.pid"),
    )
}

/// A Slurm of one node on loopback, in a folder of its own.
struct Slurm {
    folder: TempDir,
    daemons: Vec<Child>,
}

impl Slurm {
    fn start() -> Self {
        let folder = TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name).display().to_string();
        for name in ["state", "spool"] {
            fs::create_dir(path(name)).unwrap();
        }
        let socket = path("munge.socket");
        fs::write(path("slurm.conf"), configuration(&path, &socket)).unwrap();
        fs::write(path("munge.key"), [7; 1024]).unwrap();
        succeed(Command::new("chmod").args(["600", &path("munge.key")]));
        succeed(Command::new("chmod").arg("755").arg(folder.path()));
        let mut slurm = Self { folder, daemons: Vec::new() };
        let options = ["socket", "pid-file", "log-file", "seed-file"];
        let mut munge = vec!["--foreground".to_owned(), "--force".to_owned()];
        munge.push(format!("--key-file={}", slurm.path("munge.key")));
        munge.extend(options.map(|option| {
            let file = format!("munge.{}", option.trim_end_matches("-file"));
            format!("--{option}={}", slurm.path(&file))
        }));
        slurm.daemon("munged", &munge);
        wait_until("munged", || Path::new(&socket).exists());
        slurm.daemon("slurmctld", &["-D".to_owned()]);
        slurm.daemon("slurmd", &["-D".to_owned()]);
        wait_until("an idle node", || {
            let nodes = slurm.command("sinfo").args(["-h", "-o", "%t"]).output().unwrap();
            String::from_utf8_lossy(&nodes.stdout).trim() == "idle"
        });
        slurm
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.path("slurm.conf")).current_dir(self.folder.path());
        command
    }

    fn daemon(&mut self, program: &str, arguments: &[String]) {
        let mut command = self.command(program);
        command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
        self.daemons.push(command.spawn().unwrap());
    }

    /// Flies a shard and kills it while its rows have their temporary name.
    fn kill_in_mid_flight(&self, shard: usize) {
        let job = String::from_utf8(self.submit(&shard.to_string(), false).stdout).unwrap();
        let out = self.folder.path();
        let temporary = format!(".{shard}.parquet.");
        wait_until("a temporary file", || {
            let mut files = fs::read_dir(out).unwrap().map(|file| file.unwrap().file_name());
            files.any(|file| file.to_string_lossy().starts_with(&temporary))
        });
        succeed(self.command("scancel").args(["--full", "--signal=KILL", job.trim()]));
        wait_until("the end of the killed shard", || {
            self.command("squeue").arg("-h").output().unwrap().stdout.is_empty()
        });
        let is_complete = out.join(format!("{shard}.parquet")).exists();
        assert!(!is_complete, "shard {shard} was complete before it was killed");
    }

    /// Submits the shards of this list, and returns the number of the job.
    fn submit(&self, list: &str, wait: bool) -> Output {
        let mut sbatch = self.command("sbatch");
        sbatch.args(["--parsable", &format!("--array={list}")]);
        if wait {
            sbatch.arg("--wait");
        }
        sbatch.arg("shards.sh").output().unwrap()
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        for daemon in self.daemons.iter_mut().rev() {
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

#[test]
fn slurm_array_gives_the_report_of_one_process_after_a_kill_and_a_repetition() {
    const SHARDS: usize = 7;
    let needed = ["munged", "slurmctld", "slurmd", "sbatch", "scancel", "sinfo"];
    if let Some(missing) = needed.into_iter().find(|program| !is_installed(program)) {
        println!("skipped: Slurm is not installed (no {missing})");
        return;
    }
    let user = String::from_utf8(succeed(Command::new("id").arg("-u")).stdout).unwrap();
    if user.trim() != "0" {
        println!("skipped: a Slurm of its own needs the user root");
        return;
    }
    let slurm = Slurm::start();
    let out = slurm.folder.path();
    let script = format!(
        "#!/bin/sh\nexport RAYON_NUM_THREADS=1\nexec {HOST_SIM} {} \
         --shard $SLURM_ARRAY_TASK_ID/{SHARDS} --out $SLURM_ARRAY_TASK_ID.parquet\n",
        LONG.join(" ")
    );
    fs::write(out.join("shards.sh"), script).unwrap();

    slurm.kill_in_mid_flight(2);
    let rest = slurm.submit("1,3-7", true);
    assert!(rest.status.success(), "{}", String::from_utf8_lossy(&rest.stderr));
    let mut merge = Command::new(HOST_SIM);
    let files = shards(out, SHARDS);
    let incomplete = files.iter().filter(|file| file.exists());
    let refused = merge.arg("merge").args(incomplete).output().unwrap();
    let message = String::from_utf8_lossy(&refused.stderr);
    assert!(message.contains("shards 2 of 7 are missing"), "{message}");

    // Flown again, and shard 5 a second time.
    let first = fs::read(out.join("5.parquet")).unwrap();
    assert!(slurm.submit("2,5", true).status.success());
    assert!(first == fs::read(out.join("5.parquet")).unwrap());
    let repeated = out.join("5-again.parquet");
    fs::write(&repeated, first).unwrap();
    let all = [files, vec![repeated]].concat();
    assert!(merged(&all) == of_one_process(&LONG, out));
}
