# Sourced by tests that pull a USB device out at random bytes while dexeld has it; devices.sh and start_dexeld before.
#   replug DEVICE STREAM_LEN CHECK   DEVICE: the order function of a plugged device, from which dexeld streams; STREAM_LEN: bytes of
#                                    two of its frames; CHECK N: a subscriber that gets N whole frames
# How often: hil_cycles=N on the kernel's command line, else 10; hil_seed=N chooses the bytes. One time in four the plug does not
# even survive the first kilobyte: descriptors, and what the driver asks when it opens. Every other time it comes again in
# the other port. After each the stream goes on, with whole frames, and dexeld holds as many descriptors and threads
# as at first. Its resident memory may grow by 1 MB after the tenth time, or after half of them: what allocators
# and libraries keep for good they have by then, and a leak of 12 kB each time is seen in a hundred.

cycles=$(word hil_cycles) seed=$(word hil_seed)
cycles=${cycles:-10} seed=${seed:-1}

# draw N: $drawn is of 0 to N - 1
draw() {
  seed=$((seed * 6364136223846793005 + 1442695040888963407))
  drawn=$(((seed >> 33 & 0x3fffffff) % $1))
}

# held: what the service has: $n_fds, $n_threads, $rss_kb
held() {
  # shellcheck disable=SC2012 # numbers
  n_fds=$(ls "/proc/$dexeld_pid/fd" | wc -l)
  # shellcheck disable=SC2012
  n_threads=$(ls "/proc/$dexeld_pid/task" | wc -l)
  rss_kb=$(sed -n 's/^VmRSS:[[:space:]]*\([0-9]*\) kB/\1/p' "/proc/$dexeld_pid/status")
}
# what a subscriber had goes when its thread has seen that it is gone
holds_as_before() { held; [ "$n_fds" = "$was_fds" ] && [ "$n_threads" = "$was_threads" ]; }

is_out() { $unit where; [ "$answer" = 0 ]; }
meshed_more() { [ "$(counted frames)" -gt "$was_frames" ]; }

# cut_short: plugs in what goes again within the first kilobyte
cut_short() {
  draw 1000
  echo "cycle $cycle: plugged for $drawn bytes"
  $unit "unplug-after $drawn"
  $unit plug
  # fewer bytes may be asked for, while nobody takes it
  tries=0
  until is_out || [ $tries = 30 ]; do
    tries=$((tries + 1))
    sleep 0.1
  done
  $unit unplug
}

# before dexeld starts: a huge page would count as two megabytes at the first byte of it
small_pages() { echo never >/sys/kernel/mm/transparent_hugepage/enabled; }

replug() {
  unit=$1
  expect=$3
  await 60 device_is state streaming
  $expect 2
  held
  was_fds=$n_fds was_threads=$n_threads
  echo "seed $seed; $n_fds descriptors, $n_threads threads, $rss_kb kB"
  for cycle in $(seq "$cycles"); do
    draw "$2"
    at=$drawn
    $unit "unplug-after $at"
    await 60 is_out
    await 60 device_is state gone
    $expect 1
    was_frames=$(counted frames)
    draw 4
    [ "$drawn" != 0 ] || cut_short
    if [ $((cycle % 2)) = 0 ]; then $unit plug; else $unit plug-other; fi
    await 90 device_is state streaming
    await 60 meshed_more
    $expect 2
    await 20 holds_as_before
    $unit where
    echo "cycle $cycle: out after $at bytes, in port $answer again, $rss_kb kB"
    if [ "$cycle" -le $(((cycles + 1) / 2)) ] && [ "$cycle" -le 10 ]; then warm_kb=$rss_kb; fi
    [ "$rss_kb" -le $((warm_kb + 1024)) ] || wrong "it has grown from $warm_kb kB"
  done
  status
}
