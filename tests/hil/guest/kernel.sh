# The kernel interfaces that the drivers stand on are there: V4L2 (vivid, v4l2loopback), a GPIO chip, a USB
# controller with a device side, USB host controllers.
set -eu
. tests/hil/devices.sh

load_vivid
[ -c "$video" ] || wrong "$video is no device"
rmmod vivid

modprobe v4l2loopback video_nr=10 card_label=loop
udevadm settle
[ "$(video_of loop)" = /dev/video10 ] || wrong "v4l2loopback: $(ls /dev/video*)"
rmmod v4l2loopback

load_gpio_sim
[ -c "/dev/$chip" ] || wrong "no /dev/$chip"
pull 2 up
[ "$(cat "$lines/sim_gpio2/value")" = 1 ] || wrong "line 2 cannot be pulled up"
unload_gpio_sim

modprobe dummy_hcd
[ -e /sys/class/udc/dummy_udc.0 ] || wrong "no dummy_udc"
modprobe usb_f_fs
modprobe xhci-pci
await 5 test -e /sys/bus/usb/devices/usb3
rmmod dummy_hcd
