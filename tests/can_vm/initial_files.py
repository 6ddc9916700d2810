"""The first file system of the machine in QEMU: busybox, the modules that the host's files need, a script."""

import pathlib

SCRIPT = """#!/bin/busybox sh
/bin/busybox mkdir -p /proc /host
/bin/busybox mount -t proc proc /proc
for m in {modules}; do /bin/busybox insmod /$m; done
/bin/busybox mount -t 9p -o ro,trans=virtio,version=9p2000.L,msize=262144,cache=loose root /host ||
  /bin/busybox poweroff -f
/bin/busybox umount /proc
exec /bin/busybox switch_root /host "$can_vm_job/guest_init"
"""


def _entry(name, mode, data=b"", number=[0]):
    """One file of a cpio archive in the "newc" form: 13 hexadecimal numbers, name and data on multiples of 4."""
    number[0] += 1
    encoded = name.encode() + b"\0"
    fields = (number[0], mode, 0, 0, 1, 0, len(data), 0, 0, 5 if mode == 0o020600 else 0,
              1 if mode == 0o020600 else 0, len(encoded), 0)
    head = b"070701" + "".join(f"{f:08x}" for f in fields).encode() + encoded
    return head + b"\0" * (-len(head) % 4) + data + b"\0" * (-len(data) % 4)


def archive(busybox, modules):
    """Bytes for the kernel's -initrd; `modules` are files in the order of loading."""
    folder, program = 0o040755, 0o100755
    names = [pathlib.Path(m).name for m in modules]
    parts = [_entry("bin", folder), _entry("dev", folder), _entry("dev/console", 0o020600)]
    parts.append(_entry("bin/busybox", program, pathlib.Path(busybox).read_bytes()))
    parts += [_entry(n, 0o100644, pathlib.Path(m).read_bytes()) for n, m in zip(names, modules)]
    parts.append(_entry("init", program, SCRIPT.format(modules=" ".join(names)).encode()))
    return b"".join(parts) + _entry("TRAILER!!!", 0)
