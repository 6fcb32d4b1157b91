# Sourced, after blend_samples/setup.sh: a Debian 13 in a folder, for what this system does not have.
CERTIFICATES=/etc/ssl/certs/ca-certificates.crt

# make_chroot DIR LOG PACKAGE...: a Debian 13 with these packages, made and filled with what is missing (by root).
make_chroot() {
  local folder=$1 log=$2 trust=/root/certificates.crt
  shift 2
  [ "$(id -u)" -eq 0 ] || fail "Only root can change into the Debian 13 of $folder."
  if [ ! -e "$folder/ready" ]; then
    install_packages debootstrap
    debootstrap --variant=minbase trixie "$folder" >"$log" ||
      fail "debootstrap could not make a Debian 13 in $folder; its output is in $log."
    touch "$folder/ready"
  fi
  cp "$CERTIFICATES" "$folder$trust" || fail "The certificates of $CERTIFICATES could not be copied into $folder."
  chroot "$folder" dpkg -s "$@" >/dev/null 2>&1 && return
  chroot "$folder" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$@" \
    </dev/null >>"$log" || fail "apt-get could not install $* in $folder; its output is in $log."
}

# in_debian DIR COMMAND...: runs it there; pip trusts what this system trusts, a proxy for one.
in_debian() {
  local folder=$1 trust=/root/certificates.crt
  shift
  chroot "$folder" env HOME=/root LANG=C.UTF-8 PIP_CERT=$trust SSL_CERT_FILE=$trust "$@"
}
