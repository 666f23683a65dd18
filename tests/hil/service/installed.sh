# Sourced by the tests in the guest with systemd, devices.sh before: the service as it was installed.
run=/run/dexeld # where devices.sh looks for its sockets
config=/etc/dexeld/dexeld.yaml
drop_ins=/run/systemd/system/dexeld.service.d
# tests start the service oftener than systemd lets a service fail; the count of restarts begins anew as well
systemctl reset-failed 'dexeld*' 2>/dev/null || true

# shown PROPERTY [UNIT]; is PROPERTY VALUE [UNIT]; has PROPERTY VALUE [UNIT]: or the test ends
shown() { systemctl show --property "$1" --value "${2:-dexeld.service}"; }
is() { [ "$(shown "$1" "${3:-dexeld.service}")" = "$2" ]; }
has() { is "$@" || wrong "${3:-dexeld.service}: $1 is $(shown "$1" "${3:-dexeld.service}"), expected $2"; }

# small_scene: a configuration that the emulated processor can afford
small_scene() {
  cat >$config <<YAML
streams:
  - name: hall
    synthetic: {scene: hall, size: 120x80, fps: 5}
    record: {path: /var/lib/dexeld/hall.mcap, start: no}
YAML
  systemctl restart dexeld.service
}

# after each test, and one that failed: neither its drop-in nor its devices are left to the next
leave() {
  [ ! -d $drop_ins ] || without_drop_in
  [ ! -e /sys/module/vivid ] || {
    small_scene
    [ ! -d "${gadget:-}" ] || { unplug_scip && unload_scip_gadget; }
    [ -z "${turning:-}" ] || { kill $turning && wait $turning; } || true
    [ ! -d "${sim:-}" ] || unload_gpio_sim
    rmmod vivid
  }
}
trap leave EXIT

# is_connected PID: a client that the service tells of
is_connected() { status | grep -q "\"pid\":$1\b"; }

# meshed [ARGS...]: a subscriber gets a whole mesh
meshed() {
  rm -f /run/hil/mesh.ply
  timeout 60 dexel cat --frames 1 --quiet -o /run/hil/mesh.ply "$@" || wrong 'no mesh'
  [ "$(triangles)" -gt 1000 ] || wrong "a mesh of $(triangles) triangles"
}
triangles() { head -n 20 /run/hil/mesh.ply | sed -n 's/^element face //p'; }

# drop_in: its lines, from standard input, go for the service from its next start; without_drop_in takes them back
drop_in() {
  mkdir -p $drop_ins
  { echo '[Service]'; cat; } >$drop_ins/hil.conf
  systemctl daemon-reload
}
without_drop_in() {
  rm -r $drop_ins
  systemctl daemon-reload
  systemctl restart dexeld.service
}

# everything: all files but those of dpkg, of logs and caches, and accounts: what a purge must leave as it was
everything() {
  find / -xdev \( -path /var/lib/dpkg -o -path /var/log -o -path /var/cache -o -path /hil -o -path '/etc/*-' -o -path /etc/.pwd.lock \
    -o -path '/var/tmp/systemd-private-*' -o -path '/tmp/systemd-private-*' \) -prune -o -printf '%p %y %U:%G %m\n' | sort
  find /run /dev -name '*dexel*' | sort
  getent passwd
  getent group
}
