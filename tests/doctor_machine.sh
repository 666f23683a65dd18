# Sourced by what looks at dexel doctor: a machine that is made of files ($root, DEXEL_DOCTOR_ROOT), what is put into it, and what
# doctor finds there. As expect.sh besides.
. "$(dirname "$0")/../expect.sh"
export DEXEL_DOCTOR_ROOT="$run/root"
root=$DEXEL_DOCTOR_ROOT
gid=$(id -g) # the group of all files that are made here
uid=4242     # who asks, on those machines: not the owner of the files

put() {
  case $1 in */*) mkdir -p "$root/${1%/*}" ;; esac
  printf '%s\n' "$2" >"$root/$1"
}

# group NAME=NUMBER:MEMBERS...; the files' group is that which owns devices and sockets on the machine
groups() {
  : >"$root/etc/group"
  for g in "$@"; do echo "${g%%=*}:x:${g#*=}" >>"$root/etc/group"; done
}

# alice asks, in the groups of the session; the service is one of systemd. A camera, a Kinect, a scanner, a GPIO chip.
make_machine() {
  mkdir -p "$root/run/dexeld" "$root/var/lib/dexeld" "$root/etc"
  put etc/passwd "root:x:0:0::/root:/bin/sh
alice:x:$uid:1000::/:/bin/sh
dexeld:x:990:990::/:/bin/false"
  groups "dexeld=$gid:" dexel=2001:alice,dexeld dexel-admin=2002:alice video=2003:dexeld dialout=2004:
  put proc/self/status "Uid:	$uid	$uid	$uid	$uid
Gid:	1000	1000	1000	1000
Groups:	1000 2001 2002 "
  put lib/systemd/system/dexeld.service "[Service]
User=dexeld
Group=dexel
SupplementaryGroups=dexeld video dialout
RestrictAddressFamilies=AF_UNIX AF_NETLINK"
  put lib/udev/rules.d/60-dexeld.rules '# rule'
  put sys/fs/cgroup/system.slice/dexeld.service/cgroup.procs 77
  put proc/77/status "Gid:	2001	2001	2001	2001
Groups:	2001 2003 2004 $gid "
  put proc/77/limits 'Max open files            1024                 524288               files     '
  put sys/bus/usb/devices/1-2/idVendor 045e
  put sys/bus/usb/devices/1-2/idProduct 02ae
  put sys/bus/usb/devices/1-2/busnum 1
  put sys/bus/usb/devices/1-2/devnum 7
  put sys/bus/usb/devices/1-2/serial A22
  put sys/bus/usb/devices/1-3/idVendor 15d1
  put sys/bus/usb/devices/1-3/idProduct 0000
  put sys/bus/usb/devices/1-3/busnum 1
  put sys/bus/usb/devices/1-3/devnum 8
  put sys/bus/usb/devices/1-3:1.0/bInterfaceClass 02
  put sys/bus/usb/devices/1-4:1.0/bInterfaceClass 0e
  put sys/class/video4linux/video0/name 'Depth One'
  put sys/class/tty/ttyACM0/dev 166:0
  put sys/bus/gpio/devices/gpiochip0/dev 254:0
  for node in bus/usb/001/007 bus/usb/001/008 video0 ttyACM0 gpiochip0; do
    put "dev/$node" ''
    chmod 660 "$root/dev/$node"
  done
  mkdir -p "$root/sys/module/uvcvideo" "$root/sys/module/cdc_acm"
  put sys/module/usbcore/parameters/usbfs_memory_mb 16
  put facts 'adjtimex 0
now 1800000000
free /var/lib/dexeld 100000000000'
  put sys/devices/system/clocksource/clocksource0/current_clocksource tsc
  put sys/devices/system/clocksource/clocksource0/available_clocksource 'tsc hpet'
  put sys/class/rtc/rtc0/since_epoch 1800000001
  put sys/devices/system/cpu/cpu0/cpufreq/scaling_governor schedutil
  put sys/devices/system/cpu/cpu0/cpufreq/scaling_driver acpi-cpufreq
  chmod 770 "$root/var/lib/dexeld"
  config ''
}

machine() {
  rm -rf "$root"
  cp -rp "$run/whole" "$root"
}

config() { # config STREAMS...: besides those of all drivers
  put etc/dexeld/dexeld.yaml "streams:
  - name: kinect
    kinect: {serial: A22}
    record: {path: /var/lib/dexeld/kinect-%Y.mcap}
  - name: line
    hokuyo: {port: 1-3, stage: {rpm: 6}}
    gpio: {led: {line: gpiochip0:4}}
  - name: camera
    v4l2: {path: /dev/video0, fx: 400}
$1"
}

doctor() { # doctor STATUS [OPTIONS...]
  wanted=$1
  shift
  "$dexel" doctor "$@" >out 2>err
  got=$?
  [ $got = "$wanted" ] || { fail "exit $got, expected $wanted"; cat out err; }
}
never() { ! grep -qE -- "$1" out || { fail "unexpected '$1' in:"; cat out; }; }
edit='sudoedit /etc/dexeld/dexeld.yaml && dexeld -c /etc/dexeld/dexeld.yaml --check'

# finds LEVEL TOPIC TEXT [COMMAND]: a finding, and the command that follows it
finds() {
  level=$1 topic=$2 text=$3 mend=${4:-} awk '
    BEGIN {level = ENVIRON["level"]; topic = ENVIRON["topic"]; text = ENVIRON["text"]; mend = ENVIRON["mend"]}
    found {if (mend == "" || $0 == "                  $ " mend) good = 1; found = 0}
    $1 == level && $2 == topic && index($0, text) {found = 1; if (mend == "") good = 1}
    END {exit !good}' out || { fail "expected $1 of $2: '$3' and '${4:-}' in:"; cat out; }
}
