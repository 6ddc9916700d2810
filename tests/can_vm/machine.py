"""The two virtual machines: what each needs on this one, and how it is started."""

import os
import pathlib
import shutil

import initial_files

WANTED = ("overlay", "can", "can-raw", "vcan", "slcan")
MEMORY_MIB = 1024


class Broken(Exception):
    """This machine's files are not as they have to be."""


class Modules:
    """A kernel's tree of modules, as depmod leaves it."""

    def __init__(self, tree):
        self.tree, self.needs = tree, {}
        for line in (tree / "modules.dep").read_text().splitlines():
            file, _, needs = line.partition(":")
            self.needs[self._name(file)] = (file, needs.split())

    @staticmethod
    def _name(file):
        return pathlib.PurePath(file).name.partition(".ko")[0].replace("-", "_")

    def in_order(self, names):
        """Files to be loaded one after the other; those that are built in are left out."""
        builtin = {self._name(f) for f in (self.tree / "modules.builtin").read_text().split()}
        files = []
        for name in (n.replace("-", "_") for n in names):
            if name in builtin:
                continue
            if name not in self.needs:
                raise Broken(f"the kernel of {self.tree} has no module {name}")
            file, needs = self.needs[name]
            # modules.dep names the nearest last
            files += [f for f in (*reversed(needs), file) if f not in files]
        return [self.tree / f for f in files]


def newest(pattern):
    return max(pathlib.Path("/").glob(pattern.lstrip("/")), default=None, key=lambda p: p.stat().st_mtime)


def memory_folder(job):
    """Where the guest's memory may lie: in memory when there is room and programs may run from there."""
    shm = pathlib.Path("/dev/shm")
    room = shutil.disk_usage(shm).free >> 20 if shm.is_dir() else 0
    noexec = shm.is_dir() and os.statvfs(shm).f_flag & os.ST_NOEXEC
    return job if noexec or room < 2 * MEMORY_MIB else shm


class Uml:
    PROGRAM = "/usr/bin/linux.uml"

    def __init__(self):
        self.tree = newest("/usr/lib/uml/modules/*")

    def missing(self):
        if not os.access(self.PROGRAM, os.X_OK) or self.tree is None:
            return "this kernel has no CAN, and there is no user-mode-linux (tools/setup --dev installs it)"
        # its 6.1 kernel gives back fewer registers than such a processor has, and ends itself before the first program
        if "amx_tile" in pathlib.Path("/proc/cpuinfo").read_text():
            return "user-mode-linux does not run on a processor with AMX (for most tests tools/setup --qemu installs what does)"
        return None

    def modules(self):
        return Modules(self.tree).in_order(WANTED)

    def command_line(self, job):
        # the host's files are the root file system itself: nothing is copied, nothing is packed
        line = [self.PROGRAM, f"mem={MEMORY_MIB}M", "rootfstype=hostfs", "root=/dev/root", "rootflags=/", "ro",
                f"init={job}/guest_init", f"can_vm_job={job}", f"uml_dir={job}", "umid=uml", "con=null",
                "con0=null,fd:1", "panic=-1", "quiet"]
        return line, {"TMPDIR": str(memory_folder(job)), "HOME": str(job), "PATH": "/usr/bin:/bin"}


class Qemu:
    PROGRAM = "qemu-system-x86_64"
    NEEDED_EARLY = ("virtio_pci", "9pnet_virtio", "9p")

    def __init__(self):
        repository = pathlib.Path(__file__).resolve().parents[2]
        given = os.environ.get("COLIFT_CAN_VM_KERNEL")
        self.folders = [given] if given else [f"{repository}/.deps", "/"]
        self.kernel = self.tree = None
        for folder in self.folders:
            kernel = newest(f"{folder}/boot/vmlinuz-*")
            tree = kernel and pathlib.Path(folder, "lib/modules", kernel.name.removeprefix("vmlinuz-"))
            if tree and (tree / "modules.dep").exists() and os.access(kernel, os.R_OK):
                self.kernel, self.tree = kernel, tree
                break

    def missing(self):
        if shutil.which(self.PROGRAM) is None or shutil.which("busybox") is None:
            return "there is no QEMU, or no busybox (tools/setup --qemu installs them)"
        if self.kernel is None:
            return f"there is no kernel with its modules in {' or '.join(self.folders)} (tools/setup --qemu brings one)"
        return None

    def modules(self):
        return Modules(self.tree).in_order((*WANTED, "kvaser_pci"))

    def command_line(self, job):
        early = Modules(self.tree).in_order(self.NEEDED_EARLY)
        (job / "initrd").write_bytes(initial_files.archive(shutil.which("busybox"), early))
        share = "local,path={},mount_tag={},security_model=none,multidevs=remap"
        line = [shutil.which(self.PROGRAM), "-accel", "tcg", "-machine", "q35", "-cpu", "max", "-m", str(MEMORY_MIB),
                "-smp", "2", "-nodefaults", "-no-user-config", "-display", "none", "-no-reboot", "-nic", "none",
                "-kernel", str(self.kernel), "-initrd", "initrd",
                "-append", f"console=ttyS0 panic=-1 quiet rdinit=/init can_vm_job={job}",
                "-chardev", "file,id=log,path=/dev/stdout", "-serial", "chardev:log",
                "-virtfs", share.format("/", "root") + ",readonly=on", "-virtfs", share.format(job, "job"),
                "-object", "can-bus,id=bus", "-device", "kvaser_pci,canbus=bus", "-device", "kvaser_pci,canbus=bus"]
        return line, {"PATH": os.environ.get("PATH", "/usr/bin:/bin"), "HOME": str(job)}


ENGINES = {"uml": Uml, "qemu": Qemu}
