//! A disk that is soon full.

/// A file system of 64 KiB, or `None` where this machine does not let a test mount one.
pub struct SmallDisk(pub tempfile::TempDir);

impl SmallDisk {
    /// Mounts it.
    pub fn new() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mounted = std::process::Command::new("mount")
            .args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"])
            .arg(folder.path())
            .output()
            .is_ok_and(|output| output.status.success());
        mounted.then_some(Self(folder))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = std::process::Command::new("umount")
            .arg(self.0.path())
            .status();
    }
}
