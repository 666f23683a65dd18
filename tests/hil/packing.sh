# Sourced by what packs the guests: kernel modules and archives; $kernel (get_kernel.sh) before.
PATH=$PATH:/sbin:/usr/sbin
release=$(cat "$kernel/version")
tree=$(cd "$kernel/tree" && pwd)

# files_of MODULE...: their files, each after those that it depends on
files_of() {
  for m in "$@"; do modprobe -d "$tree" -S "$release" --show-depends "$m" || return; done >"$hil/modules.list"
  sed -n 's/^insmod \([^ ]*\).*/\1/p' "$hil/modules.list" | awk '!seen[$0]++'
}

# modules_into ROOT MODULE...: they and what they depend on, to where modprobe seeks them
modules_into() {
  root=$1
  shift
  files=$(files_of "$@")
  for file in $files; do
    to=$root${file#"$tree"}
    mkdir -p "${to%/*}"
    cp "$file" "$to"
  done
  cp "$tree/lib/modules/$release"/modules.builtin* "$tree/lib/modules/$release"/modules.order \
    "$root/lib/modules/$release"
  depmod -b "$root" "$release"
}

# archive ROOT FILE: of the folder, which goes
archive() {
  (cd "$1" && find . | sort | cpio --quiet -o -H newc -R 0:0) >"$2"
  rm -rf "$1"
}
