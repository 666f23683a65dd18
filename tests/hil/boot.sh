# Sourced by what runs a guest: QEMU, and what is made of the guest's last line. $hil before. Always emulated: what there is of KVM on a
# build machine may hang.
limit_s=${HIL_LIMIT_S:-1500}

# qemu APPEND ARGS...: the kernel with these words on its command line
qemu() {
  append=$1
  shift
  timeout --foreground "$limit_s" qemu-system-x86_64 -accel tcg,thread=multi -machine pc -cpu max -nodefaults -no-user-config \
    -display none -no-reboot -kernel "$hil/kernel/vmlinux" \
    -append "console=ttyS0 quiet loglevel=3 panic=-1 tsc=reliable mitigations=off nokaslr random.trust_cpu=on $append" "$@"
}

# show FOLDER: what the guest tells on standard input, into FOLDER/results.log; shown without the last line
show() { tee "$1/results.log" | sed -u '/^[0-9][0-9]* passed, /d'; }

# verdict FOLDER: the guest has ended; its last line, or one that says that there was none. True when all passed.
verdict() {
  results=$1/results.log
  if ! tail -n 1 "$results" | grep -qE '^[0-9]+ passed'; then
    echo "FAIL  the guest ended before its tests did; the end of $1/console.log:"
    tail -n 20 "$1/console.log" | sed 's/^/      /'
    echo "$(grep -c '^pass' "$results") passed, $(($(grep -c '^FAIL' "$results") + 1)) failed" >>"$results"
  fi
  # hil.sh adds them up
  [ -n "${HIL_PART:-}" ] || tail -n 1 "$results"
  tail -n 1 "$results" | grep -q ' 0 failed'
}
