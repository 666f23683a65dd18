#!/bin/sh
# dexel doctor on machines that are made of files (DEXEL_DOCTOR_ROOT): one where all is well, then one thing wrong at a time, each
# of which is found with the command that mends it. And a running service is asked.
set -u
. "$(dirname "$0")/../doctor_machine.sh"

# ---- all is well; nobody listens yet --------------------------------------------------------------------
make_machine
mv "$root" "$run/whole"
machine
doctor 1
[ "$(grep -c '^problem' out)" = 2 ] || { fail "problems of a machine that has none"; cat out; }
! grep -q '^warning' out || { fail "warnings of a machine that has none"; cat out; }
finds problem sockets '/run/dexeld/mesh.sock is not there' 'sudo systemctl start dexeld.socket dexeld-control.socket dexeld.service'
finds ok config '/etc/dexeld/dexeld.yaml: 3 streams'
finds ok groups 'alice is in dexel, and may subscribe'
finds ok groups "the service's user dexeld has its groups"
finds ok rule '/lib/udev/rules.d/60-dexeld.rules is installed'
finds ok devices '/dev/bus/usb/001/007 (camera of Kinect for Xbox 360), group dexeld, mode 0660: dexeld may open it'
finds ok devices '/dev/video0 (Depth One)'
finds ok devices '/dev/gpiochip0 (GPIO lines)'
finds ok streams 'kinect: what it reads (kinect) is there'
finds ok usb 'usbfs has 16 MB for transfers, the devices attached take 544 kB'
finds ok disk 'kinect: there is room in /var/lib/dexeld'
finds ok limits 'the service may have 1024 open files, 344 are needed'
"$dexel" doctor --quiet >out
! grep -q '^ok' out || fail '--quiet tells what is well'
"$dexel" doctor --json >out
grep -q '"problems": 2, "warnings": 0, "findings": \[' out || { fail '--json'; cat out; }
grep -q '{"level": "problem", "topic": "sockets", "text": "[^"]*", "mend": "sudo systemctl start ' out || { fail '--json'; cat out; }
expect 2 "$dexel" doctor more
expect 2 "$dexel" doctor --more
expect 0 "$dexel" doctor --help
if [ -w /dev/full ]; then
  for o in --quiet --json; do
    "$dexel" doctor $o >/dev/full 2>err
    [ $? = 1 ] || fail "a full disk: $o"
    [ "$(cat err)" = 'dexel: standard output: No space left on device' ] || { fail "a full disk: $o"; cat err; }
  done
fi

# from here on a service answers: sockets, then everything else one by one
serve() { # serve STREAM [KEYS]
  cat >"$run/serve.yaml" <<YAML
${2:-max_requests: 10000}
socket: $root/run/dexeld/mesh.sock
control_socket: $root/run/dexeld/control.sock
streams:
  - name: ball
    synthetic: {scene: sphere, size: 32x16}
$1
YAML
  groups "dexeld=$gid:" dexel=2001:alice,dexeld dexel-admin=2002:alice video=2003:dexeld dialout=2004:
  start_dexeld -c "$run/serve.yaml" || exit 1
}
serve ''
doctor 0
finds ok service 'the service answers, version '
finds ok service 'ball is '
finds warning sockets 'mesh.sock is of the group dexeld, not of dexel' 'sudo chgrp dexel /run/dexeld/mesh.sock'
finds warning sockets 'control.sock is of the group dexeld, not of dexel-admin' 'sudo chgrp dexel-admin /run/dexeld/control.sock'
groups "dexel=$gid:alice"
doctor 0
finds warning sockets '/run/dexeld/mesh.sock: alice may not connect' 'sudo adduser alice dexel && newgrp dexel'
# one that was started by hand, where no service is installed
sed -i.whole /^dexeld:/d "$root/etc/passwd"
groups dexel=2001:alice
doctor 1
finds warning sockets '/run/dexeld/mesh.sock: alice may not connect' "sudo -u '#$(id -u)' dexel status"
doctor 1 --control /run/dexeld/control.sock
finds warning sockets '/run/dexeld/mesh.sock: alice may not connect' \
  "sudo -u '#$(id -u)' dexel status --socket /run/dexeld/control.sock"
mv "$root/etc/passwd.whole" "$root/etc/passwd"
groups "dexel=$gid:alice"
chmod 666 "$root/run/dexeld/mesh.sock"
doctor 0
finds warning sockets 'has mode 0666: everybody may connect' 'sudo chmod 0660 /run/dexeld/mesh.sock'
finds ok sockets '/run/dexeld/mesh.sock: somebody answers'
# whoever it is that the service runs as now: of systemd, or started by hand
chmod 700 "$root/var/lib/dexeld"
put proc/77/status 'Uid:	990	990	990	990'
doctor 1
finds problem disk 'kinect: dexeld may not write to /var/lib/dexeld' 'sudo chown dexeld /var/lib/dexeld'
rm -r "$root/sys/fs"
doctor 0
finds ok disk 'kinect: there is room in /var/lib/dexeld'
kill -9 "$dexeld_pid"
wait "$dexeld_pid" 2>/dev/null
dexeld_pid=
doctor 1
finds problem sockets '/run/dexeld/mesh.sock: nobody answers (Connection refused)' \
  'sudo systemctl restart dexeld.socket dexeld-control.socket dexeld.service'
rm "$root/run/dexeld/mesh.sock"
put run/dexeld/mesh.sock ''
doctor 1
finds problem sockets '/run/dexeld/mesh.sock is no socket' \
  'sudo rm /run/dexeld/mesh.sock && sudo systemctl start dexeld.socket dexeld-control.socket dexeld.service'
# what is no socket, and not known to be the service's, stays
put a.log ''
doctor 1 --socket /a.log
finds problem sockets '/a.log is a file, and no socket of a service' 'dexel doctor --config /etc/dexeld/dexeld.yaml'
never 'sudo rm'
put etc/dexeld/dexeld.yaml 'socket: /a.log
streams: [{name: s, synthetic: {scene: hall}}]'
doctor 1
finds problem sockets '/a.log is no socket, but a file' "$edit"
never 'sudo rm'
export DEXELD_CONTROL=/b.sock
doctor 1
finds problem sockets '/b.sock is not there' 'env -u DEXELD_CONTROL dexel doctor --config /etc/dexeld/dexeld.yaml'
doctor 1 --socket /a.log
finds problem sockets '/a.log.control is not there' 'dexel doctor --config /etc/dexeld/dexeld.yaml'
unset DEXELD_CONTROL
doctor 1 --socket "/$(printf 'no\033[2J')" # nothing that it prints is for the terminal
finds problem sockets '/no [2J is not there'
never "$(printf '\033')"

# a refusal is told as such, and the wrong socket as what it is
machine
serve '' 'max_requests: 1'
tries=0
until grep -q '^warning  service  .*: the service: too many requests: 1 a second' out; do
  "$dexel" doctor >out 2>err
  tries=$((tries + 1))
  [ $tries -lt 300 ] || { fail 'no refusal'; cat out; break; }
done
never 'version unknown|restart'
DEXELD_CONTROL=/run/dexeld/mesh.sock doctor 1
finds problem service 'this seems to be the mesh socket' 'env -u DEXELD_CONTROL dexel doctor --config /etc/dexeld/dexeld.yaml'
stop_dexeld

# a device that is not there is one problem, whoever tells of it
machine
put etc/dexeld/dexeld.yaml 'streams: [{name: far, kinect: {serial: nowhere}}]'
serve '  - {name: far, kinect: {serial: nowhere}}'
doctor 1
finds problem streams 'far: a Kinect camera (serial nowhere) is not there' 'dexel devices'
finds ok service 'ball is '
grep -q '^1 problem, ' out || { fail 'one fault is told twice'; cat out; }
stop_dexeld

# what a service says of a scanner on the network, and of a recording
machine
put etc/dexeld/dexeld.yaml 'streams: [{name: net, hokuyo: {tcp: "127.0.0.1:1", stage: {rpm: 3}}}]'
serve "  - {name: net, hokuyo: {tcp: '127.0.0.1:1', stage: {rpm: 3}}}
  - {name: bad, synthetic: {scene: sphere, size: 32x16}, record: {path: $root/none/bad.mcap}}"
told() { # told TEXT...: all of it stands in the status
  "$dexel" status --json --socket "$root/run/dexeld/control.sock" >told
  for text; do grep -qE -- "$text" told || return 1; done
}
tries=0
until told '"name": ?"net", ?"state": ?"(gone|faulted)"' 'No such file or directory'; do
  tries=$((tries + 1))
  [ $tries -lt 3000 ] || { fail 'faults are not told in the status'; cat told; break; }
done
doctor 1
finds ok streams 'net: 127.0.0.1:1 (hokuyo) was not looked at'
finds problem service "the service's unit keeps it from the network" \
  'sudo install -D -m 644 /usr/share/doc/dexeld/network.conf /etc/systemd/system/dexeld.service.d/network.conf && sudo systemctl daemon-reload && sudo systemctl restart dexeld'
finds problem service "bad is not recorded in $root/none/bad.mcap: No such file or directory" 'dexel record status --stream bad'
put etc/systemd/system/dexeld.service.d/n.conf '[Service]
RestrictAddressFamilies=AF_INET AF_INET6'
doctor 1 --control /run/dexeld/control.sock
finds problem service 'net is ' 'journalctl -u dexeld -n 50'
finds problem service 'bad is not recorded' 'dexel record status --stream bad --socket /run/dexeld/control.sock'
stop_dexeld

# a stream that has failed; sockets that are told of
machine
printf 'not a scan' >"$run/bad.pcd"
start_dexeld --replay "$run/bad.pcd" --loop --socket "$root/s" || exit 1
"$dexel" cat --socket "$root/s" --timeout 300 >/dev/null 2>&1 # until the stream is over
expect 0 "$dexel" doctor --socket /s
finds ok sockets '/s.control: somebody answers'
finds warning service 'replay is ended: ' 'journalctl -u dexeld -n 50'
stop_dexeld

# ---- one thing at a time --------------------------------------------------------------------------------
# wrong LEVEL TOPIC TEXT COMMAND: that one is found; then a whole machine again. (Nobody listens: so the status is 1.)
wrong() {
  doctor 1
  finds "$@"
  machine
}
machine
rm "$root/etc/dexeld/dexeld.yaml"
wrong warning config 'there is no /etc/dexeld/dexeld.yaml' 'sudo apt-get install --reinstall -o Dpkg::Options::=--force-confmiss dexeld'
config '    nonsense: 1'
wrong problem config 'nonsense' "$edit"
never '^ok +(disk|limits|streams)|GPIO'
config '    nonsense: 1'
wrong ok sockets 'the sockets were not looked at'
never '^problem +sockets'
put "a place/it's.yaml" 'streams: 1'
doctor 1 --config "/a place/it's.yaml"
finds problem config 'streams' \
  "sudoedit '/a place/it'\\''s.yaml' && dexeld -c '/a place/it'\\''s.yaml' --check"
machine

groups "dexeld=$gid:" dexel-admin=2002:alice video=2003:dexeld dialout=2004:
wrong warning groups 'there is no group dexel: root and the service alone may subscribe' 'sudo groupadd --system dexel'
groups "dexeld=$gid:" dexel-admin=2002:alice video=2003:dexeld dialout=2004:
put usr/lib/sysusers.d/dexeld.conf ''
wrong warning groups 'there is no group dexel' 'sudo systemd-sysusers'
put proc/self/status "Uid:	$uid
Gid:	1000
Groups:	1000 2002 "
wrong warning groups 'alice is in dexel, but not yet in this session' 'newgrp dexel'
put proc/self/status "Uid:	$uid
Gid:	1000
Groups:	1000 2001 "
groups "dexeld=$gid:" dexel=2001:alice,dexeld dexel-admin=2002: video=2003: dialout=2004:
wrong warning groups 'alice is not in dexel-admin, and may not operate' 'sudo adduser alice dexel-admin'
put lib/systemd/system/dexeld.service '[Service]'
wrong warning groups "the service's user dexeld is not in dialout" 'sudo adduser dexeld dialout'
put proc/77/status "Gid:	2001
Groups:	2001 2004 $gid "
wrong warning groups 'dexeld is in video, but was not when it was started' 'sudo systemctl restart dexeld'
put etc/passwd "alice:x:$uid:1000::/:/bin/sh"
wrong warning groups 'there is no user dexeld for the service' 'sudo adduser --system --group --no-create-home dexeld'
put proc/self/status "Uid:	0
Gid:	0
Groups:	0 "
wrong ok groups 'root may subscribe in any case'

rm "$root/lib/udev/rules.d/60-dexeld.rules"
wrong problem rule 'the udev rule 60-dexeld.rules is not installed' 'sudo apt-get install --reinstall dexeld'
rm -r "$root/lib/udev/rules.d/60-dexeld.rules" "$root/sys/bus/usb"
wrong warning rule 'the udev rule 60-dexeld.rules is not installed' 'sudo apt-get install --reinstall dexeld'
mkdir -p "$root/etc/udev/rules.d"
: >"$root/etc/udev/rules.d/60-dexeld.rules"
wrong problem rule 'is empty, and hides the rule' 'sudo rm /etc/udev/rules.d/60-dexeld.rules && sudo udevadm control --reload'

chmod 600 "$root/dev/bus/usb/001/007"
wrong problem devices 'mode 0600: dexeld may not open it' \
  'sudo udevadm control --reload && sudo udevadm trigger --action=add --name-match=/dev/bus/usb/001/007'
chmod 600 "$root/dev/bus/usb/001/007"
rm "$root/lib/udev/rules.d/60-dexeld.rules"
wrong problem devices 'mode 0600: dexeld may not open it' \
  'sudo apt-get install --reinstall dexeld && sudo udevadm control --reload && sudo udevadm trigger --action=add --name-match=/dev/bus/usb/001/007'
groups dexeld=990: dexel=2001:alice,dexeld dexel-admin=2002:alice video=2003:dexeld dialout=2004: "plugdev=$gid:"
case $gid in
0) wrong problem devices 'group plugdev, mode 0660: dexeld may not open it' \
  'sudo udevadm control --reload && sudo udevadm trigger --action=add --name-match=/dev/video0' ;;
*) wrong problem devices 'group plugdev, mode 0660: dexeld may not open it' 'sudo adduser dexeld plugdev && sudo systemctl restart dexeld' ;;
esac
chmod 600 "$root/dev/ttyACM0"
wrong warning devices '/dev/ttyACM0 (serial port of USB), group dexeld, mode 0600: dexeld may not open it' \
  'sudo udevadm control --reload && sudo udevadm trigger --action=add --name-match=/dev/ttyACM0'
chmod 666 "$root/dev/video0"
wrong warning devices 'mode 0666: everybody may write to it' 'sudo chmod o-rw /dev/video0'
rm "$root/dev/gpiochip0"
wrong problem devices '/dev/gpiochip0 (GPIO lines) has no node, though the kernel knows the device' 'sudo udevadm trigger --action=add'
# no user for the service: who asks is looked at
put etc/passwd "alice:x:$uid:1000::/:/bin/sh"
wrong problem devices 'alice may not open it'

rm "$root/dev/video0"
wrong problem streams 'camera: /dev/video0 is not there' 'dexel devices'
put sys/bus/usb/devices/1-2/serial A23
wrong problem streams 'kinect: a Kinect camera (serial A22) is not there' 'dexel devices'
mv "$root/sys/bus/usb/devices/1-3" "$root/sys/bus/usb/devices/1-5"
wrong problem streams 'line: a Hokuyo scanner on USB (port 1-3) is not there' 'dexel devices'
rm -r "$root/sys/bus/usb/devices/1-2"
put etc/dexeld/dexeld.yaml 'streams: [{name: any, kinect: {}}]'
wrong problem streams 'any: a Kinect camera is not there' 'dexel devices'
config '  - {name: old, file: {path: /rec/*.mcap}}'
wrong problem streams 'old: /rec/*.mcap is not there' "$edit"
config '  - {name: old, file: {path: /rec/*.mcap}}'
mkdir "$root/rec"
wrong problem streams 'old: /rec/*.mcap is not there' 'ls -ltr /rec'
eye() { # eye KEYS: of the camera on USB
  put sys/bus/usb/devices/1-4/serial D435
  mkdir "$root/sys/bus/usb/devices/1-4/1-4:1.0"
  ln -s ../../../bus/usb/devices/1-4/1-4:1.0 "$root/sys/class/video4linux/video0/device"
  put etc/dexeld/dexeld.yaml "streams: [{name: eye, v4l2: {$1, fx: 400}}]"
}
eye 'serial: D436'
wrong problem streams 'eye: a camera (serial D436) is not there' 'dexel devices'
eye 'serial: D435, port: 1-5'
wrong problem streams 'eye: a camera (serial D435, port 1-5) is not there' 'dexel devices'
eye 'serial: D435, port: 1-4'
wrong ok streams 'eye: what it reads (v4l2) is there'
eye 'path: pci-0000:00:14.0-usb-0:4:1.0'
wrong ok streams 'eye: pci-0000:00:14.0-usb-0:4:1.0 (v4l2) was not looked at'

rmdir "$root/sys/module/uvcvideo"
wrong problem modules "the kernel's uvcvideo is not loaded" 'sudo modprobe uvcvideo'
rmdir "$root/sys/module/cdc_acm"
wrong warning modules "the kernel's cdc_acm is not loaded" 'sudo modprobe cdc_acm'
rm -r "$root/sys/module/cdc_acm" "$root/sys/bus/usb/devices/1-3:1.0"
wrong ok modules 'cdc_acm is not needed: no scanners on USB as serial ports are attached'
put etc/dexeld/dexeld.yaml 'streams: [{name: any, kinect: {}}]'
wrong ok modules 'GPIO is not needed: no stream uses lines'
rm -r "$root/sys/module/usbcore" "$root/sys/bus/usb"
wrong ok usb 'memory of usbfs is not needed'
rm -r "$root/sys/bus/gpio"
wrong problem modules 'the kernel has no GPIO chip: plug in an adapter'
rm -r "$root/sys/bus/gpio"
put sys/bus/usb/devices/1-5:1.2/modalias 'usb:v04D8p00DDd0100dcEFdsc02dp01ic03isc00ip00in02'
wrong problem modules 'the module of the MCP2221 that is attached is not loaded' 'sudo modprobe hid_mcp2221'
for encoder in '' ', encoder: {a: gpiochip0:1, b: gpiochip0:2}'; do
  rm -r "$root/sys/bus/gpio"
  put etc/dexeld/dexeld.yaml "streams: [{name: net, hokuyo: {tcp: 10.0.0.9, stage: {rpm: 3$encoder}}}]"
  case $encoder in
  '') wrong ok modules 'GPIO is not needed: no stream uses lines' ;;
  *) wrong problem modules 'streams want GPIO lines' ;;
  esac
done

usbfs=/sys/module/usbcore/parameters/usbfs_memory_mb
for n in 1 2 3; do
  cp -r "$root/sys/bus/usb/devices/1-2" "$root/sys/bus/usb/devices/2-$n"
done
put $usbfs 1
wrong problem usb 'usbfs has 1 MB for transfers, the devices attached take 1984 kB' "echo 64 | sudo tee $usbfs"
put $usbfs 8
wrong warning usb 'usbfs has 8 MB for transfers of all programs' "echo 64 | sudo tee $usbfs"
put $usbfs 0
wrong ok usb 'usbfs has no bound of memory'

put facts 'adjtimex 5
now 1800000000'
wrong warning clocks 'nothing synchronises the clock' 'sudo timedatectl set-ntp true'
source=/sys/devices/system/clocksource/clocksource0
put $source/current_clocksource hpet
wrong warning clocks "the clock's source is hpet" "echo tsc | sudo tee $source/current_clocksource"
put sys/class/rtc/rtc0/since_epoch 1799999000
wrong warning clocks "the board's clock is -1000 s off" 'sudo hwclock --systohc'
put sys/class/rtc/rtc0/since_epoch 1800007201
wrong warning clocks "the board's clock is 7201 s off: it has local time" 'sudo timedatectl set-local-rtc 0'

put facts 'adjtimex 0
now 1800000000
free /var/lib/dexeld 1000000000'
wrong warning disk 'kinect: 953 MB are free in /var/lib/dexeld; nothing bounds its recordings (record.keep_mib)' \
  'ls -ltr /var/lib/dexeld'
put facts 'adjtimex 0
now 1800000000
free /var/lib/dexeld 1000000000'
put etc/dexeld/dexeld.yaml 'streams: [{name: s, synthetic: {scene: hall}, record: {path: /var/lib/dexeld/s.mcap, keep_mib: 4096}}]'
wrong warning disk 's: 953 MB are free in /var/lib/dexeld; record.keep_mib bounds its recordings' 'ls -ltr /var/lib/dexeld'
put facts 'adjtimex 0
now 1800000000
free /var/lib/dexeld 1000000'
wrong problem disk 'kinect: 0 MB are free' 'ls -ltr /var/lib/dexeld'
rmdir "$root/var/lib/dexeld"
wrong problem disk 'there is no folder /var/lib/dexeld' 'sudo install -d -o dexeld -g dexel -m 750 /var/lib/dexeld'
chmod 700 "$root/var/lib/dexeld"
wrong problem disk 'dexeld may not write to /var/lib/dexeld' 'sudo chown dexeld /var/lib/dexeld'
recorded() { put etc/dexeld/dexeld.yaml "streams: [{name: s, synthetic: {scene: hall}, record: {path: \"$1\"}}]"; }
recorded /eyes.mcap # only what is the service's own is given to it
wrong problem disk 's: dexeld may not write to /' \
  'sudo install -d -o dexeld -g dexel -m 750 /dexeld && sudoedit /etc/dexeld/dexeld.yaml'
recorded "/a place; it's/s.mcap"
wrong problem disk "s: there is no folder /a place; it's" \
  "sudo install -d -o dexeld -g dexel -m 750 '/a place; it'\\''s'"
mkdir "$root/srv"
recorded /var/lib/dexeld/../../../srv/s.mcap # which is not in it
wrong problem disk 's: dexeld may not write to /var/lib/dexeld/../../../srv' \
  'sudo install -d -o dexeld -g dexel -m 750 /var/lib/dexeld/../../../srv/dexeld && sudoedit /etc/dexeld/dexeld.yaml'
recorded -r/s.mcap
wrong problem disk 's: there is no folder -r' 'sudo install -d -o dexeld -g dexel -m 750 ./-r'
recorded /none/s.mcap
groups "dexeld=$gid:"
wrong problem disk 's: there is no folder /none' 'sudo install -d -o dexeld -m 750 /none'
recorded /proc/77/status/s.mcap
wrong problem disk 's: /proc/77/status is no folder' "$edit"

metrics() { put etc/dexeld/dexeld.yaml "metrics_file: $1/dexeld.prom
streams: [{name: s, synthetic: {scene: hall}}]"; }
metrics /srv/m
wrong problem disk 'metrics_file: there is no folder /srv/m' 'sudo install -d -o dexeld -g dexel -m 755 /srv/m'
metrics /srv/m
mkdir -p "$root/srv/m"
wrong problem disk 'metrics_file: dexeld may not write to /srv/m' \
  'sudo install -d -o dexeld -g dexel -m 755 /srv/m/dexeld && sudoedit /etc/dexeld/dexeld.yaml'
metrics /run/dexeld-metrics
wrong problem disk 'metrics_file: there is no folder /run/dexeld-metrics' 'sudo systemctl restart dexeld'
metrics /run/dexeld-metrics
rm -r "$root/sys/fs"
wrong ok disk 'metrics_file: /run/dexeld-metrics is made when the service starts'
metrics /var/lib/dexeld
wrong ok disk 'metrics_file: the service may write to /var/lib/dexeld'

put proc/77/limits 'Max open files            256                 524288               files     '
wrong problem limits 'the service may have 256 open files, 256 subscribers and 3 streams need 344' \
  "printf '[Service]\\nLimitNOFILE=688\\n' | sudo install -D -m 644 /dev/stdin /etc/systemd/system/dexeld.service.d/files.conf && sudo systemctl daemon-reload && sudo systemctl restart dexeld"
rm -r "$root/sys/fs"
put proc/self/limits 'Max open files            256                 524288               files     '
wrong problem limits 'a program of this shell may have 256 open files' 'ulimit -n 688'

put sys/devices/system/cpu/cpu0/cpufreq/scaling_governor powersave
wrong warning cpu '1 of 1 processors stay at their lowest frequency' \
  'echo schedutil | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor'
put sys/devices/system/cpu/cpu0/cpufreq/scaling_governor powersave
put sys/devices/system/cpu/cpu0/cpufreq/scaling_driver intel_pstate
wrong ok cpu 'processors follow the load'

# this machine: whatever is found, it is told
unset DEXEL_DOCTOR_ROOT
"$dexel" doctor >out 2>err
[ $? -le 1 ] || fail "this machine: $(cat err)"
grep -qE '^[0-9]+ problems?, [0-9]+ warnings?$' out || fail 'this machine: no sum'
exit $bad
