"""`dexel status --watch` on a terminal of our own (a pty): a screen is drawn that fits, in colours unless NO_COLOR is set;
it is drawn again; the terminal is put back when q is typed and when a signal comes. The service is at the socket that is
the first word; `dexel` is the second.
"""

import fcntl
import os
import pty
import re
import select
import signal
import struct
import sys
import termios
import time

CODE = re.compile(rb"\x1b\[([?0-9;]*)([A-Za-z])")
LEFT = b"\x1b[?7h\x1b[?25h\x1b[?1049l"


class Screen:
    def __init__(self, socket, dexel, columns=80, rows=24, **env):
        self.columns, self.rows, self.seen = columns, rows, b""
        self.master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("4H", rows, columns, 0, 0))
        self.before = termios.tcgetattr(slave)
        self.slave = slave
        self.pid = os.fork()
        if self.pid == 0:
            os.setsid()
            fcntl.ioctl(slave, termios.TIOCSCTTY, 0)
            for fd in range(3):
                os.dup2(slave, fd)
            os.closerange(3, 256)
            environment = {k: v for k, v in os.environ.items() if k != "NO_COLOR"}
            environment.update({"TERM": "xterm", **env})
            os.execve(dexel, ["dexel", "status", "--watch", "--socket", socket], environment)

    def read(self):
        ready, _, _ = select.select([self.master], [], [], 20)
        assert ready, f"nothing was drawn for 20 s after {self.seen[-500:]!r}"
        self.seen += os.read(self.master, 65536)

    def await_text(self, text, times=1):
        while self.seen.count(text) < times:
            self.read()

    def frames(self):
        """What was drawn, each from the top left corner on, that is whole."""
        return [f.split(b"\x1b[J")[0] for f in self.seen.split(b"\x1b[H")[1:] if b"\x1b[J" in f]

    def type(self, keys):
        os.write(self.master, keys)

    def resize(self, columns, rows):
        self.columns, self.rows = columns, rows
        fcntl.ioctl(self.master, termios.TIOCSWINSZ, struct.pack("4H", rows, columns, 0, 0))

    def end(self):
        """Its status; the terminal is as it was."""
        _, status = os.waitpid(self.pid, 0)
        while select.select([self.master], [], [], 0)[0]:
            self.read()
        assert self.seen.count(LEFT) == self.seen.count(b"\x1b[?1049h"), f"not left: {self.seen[-200:]!r}"
        assert self.seen.endswith(LEFT), f"drawn after the end: {self.seen[-200:]!r}"
        assert termios.tcgetattr(self.slave) == self.before, "the terminal is another one"
        os.close(self.master)
        os.close(self.slave)
        return status


def fits(screen, frame):
    lines = [CODE.sub(b"", line).decode() for line in frame.split(b"\r\n")]
    assert len(lines) <= screen.rows, f"{len(lines)} lines of {screen.rows}"
    for line in lines:
        assert len(line) <= screen.columns, f"{len(line)} columns of {screen.columns}: {line}"
    return lines


def test_screen(args):
    screen = Screen(*args)
    screen.await_text(b"\x1b[J", 3)
    lines = fits(screen, screen.frames()[-1])
    assert lines[0].startswith("dexeld ") and "clients 1" in lines[0], lines[0]
    assert any(re.match(r"STREAM +STATE +FPS", line) for line in lines), lines
    box = next(line for line in lines if line.startswith("box "))
    assert re.match(r"box +live +[0-9.]+ +[0-9.]+ s ", box), box
    client = next(line for line in lines if re.match(r" +[0-9]+ box", line))
    assert re.search(r"[0-9.]+ k?M?B ", client), f"no rate: {client}"
    assert b"\x1b[32mlive\x1b[0m" in screen.seen, "live is not green"
    screen.resize(40, 5)
    while b"more lines" not in screen.seen:
        screen.read()
    fits(screen, screen.seen.split(b"\x1b[H")[-1].split(b"\x1b[J")[0])
    screen.resize(200, 50)
    screen.await_text(b"COALESCED/S")
    screen.type(b"x")
    screen.type(b"q")
    assert screen.end() == 0


def test_signals(args):
    for number, key in ((signal.SIGINT, b"\x03"), (signal.SIGTERM, None), (signal.SIGHUP, None)):
        screen = Screen(*args)
        screen.await_text(b"\x1b[J")
        if key:
            screen.type(key)
        else:
            os.kill(screen.pid, number)
        assert os.WTERMSIG(screen.end()) == number
    screen = Screen(*args)  # stopped, and continued
    screen.await_text(b"\x1b[J")
    screen.type(b"\x1a")
    _, status = os.waitpid(screen.pid, os.WUNTRACED)
    assert os.WIFSTOPPED(status)
    screen.await_text(LEFT)
    assert termios.tcgetattr(screen.slave) == screen.before, "stopped, the terminal is another one"
    os.kill(screen.pid, signal.SIGCONT)
    screen.await_text(b"\x1b[?1049h", 2)
    screen.type(b"q")
    assert screen.end() == 0


def test_no_colour(args):
    screen = Screen(*args, NO_COLOR="1")
    screen.await_text(b"\x1b[J", 2)
    assert not [code for code in CODE.findall(screen.seen) if code[1] == b"m"], "colours in spite of NO_COLOR"
    screen.type(b"q")
    assert screen.end() == 0


def test_dumb(args):
    screen = Screen(*args, TERM="dumb")
    screen.await_text(b"memory ", 2)
    assert b"\x1b" not in screen.seen, "codes on a terminal that knows none"
    os.kill(screen.pid, signal.SIGTERM)
    os.waitpid(screen.pid, 0)


def test_lost(args):
    """The service goes: its last state stays, and why; it comes again."""
    socket, dexel = args
    os.symlink(socket + ".control", socket + ".moved.control")
    open(socket + ".moved", "w").close()
    screen = Screen(socket + ".moved", dexel, columns=120)
    screen.await_text(b"\x1b[J")
    os.rename(socket + ".moved.control", socket + ".away")
    screen.await_text(b"no dexeld answers here")
    os.rename(socket + ".away", socket + ".moved.control")
    n = len(screen.seen)
    while b"no dexeld" in screen.seen[n:].split(b"\x1b[H")[-1] or screen.seen[n:].count(b"\x1b[J") < 2:
        screen.read()
    screen.type(b"q")
    assert screen.end() == 0


if __name__ == "__main__":
    for test in (test_screen, test_signals, test_no_colour, test_dumb, test_lost):
        began = time.monotonic()
        test(sys.argv[1:])
        print(f"{test.__name__}: {time.monotonic() - began:.1f} s")
