#!/bin/sh
# Builds five drivers that Debian's kernel lacks, from Debian's source of that kernel, into the
# modules of a guest:
#   gpio-sim   simulated GPIO banks, with irq_sim, which gpio-sim needs and Debian's kernel lacks too
#   ctucanfd   the CTU CAN FD controller, the only one of the emulator for CAN FD
#   pwm-pca9685   the PWM chip PCA9685, which Debian has for the processors of boards only
#   spidev     SPI ports as devices, likewise
#   spi-butterfly   the SPI port at a parallel port with a clock: as Debian has it, each rate is the same
#
#   tests/lab/build_modules.sh KERNEL_FOLDER
#
# The headers are unpacked and not installed.
set -eu
PATH=$PATH:/usr/sbin:/sbin # depmod

kernel=$(cd "$1" && pwd)
version=$(cat "$kernel/ready")
series=$(echo "$version" | cut -d . -f 1-2)
[ ! "$kernel/modules-built" -nt "$0" ] || exit 0

work="$kernel/build"
rm -rf "$work"
mkdir -p "$work/gpio" "$work/can" "$work/pwm" "$work/spi"
cd "$work"
common=linux-headers-${version%-amd64}-common
echo "Laboratory: downloading headers and source of $version, and building gpio-sim, ctucanfd, pwm-pca9685, spidev, spi-butterfly" >&2
apt-get -q download "linux-headers-$version" "$common" "linux-kbuild-$series" \
    "linux-source-$series" >apt.log 2>&1 || {
    cat apt.log >&2
    exit 1
}
for package in linux-headers-*.deb linux-kbuild-*.deb; do
    dpkg-deb -x "$package" .
done
# The file names the other half of the headers by their installed path.
echo "include $work/usr/src/$common/Makefile" >"usr/src/linux-headers-$version/Makefile"

dpkg-deb --fsys-tarfile linux-source-*.deb |
    tar -xO --wildcards './usr/src/linux-source-*.tar.xz' |
    tar -xJ --strip-components=1 --wildcards '*/drivers/gpio/gpio-sim.c' \
        '*/drivers/gpio/gpiolib.h' '*/kernel/irq/irq_sim.c' '*/drivers/net/can/ctucanfd/*' \
        '*/drivers/pwm/pwm-pca9685.c' '*/drivers/spi/spidev.c' '*/drivers/spi/spi-butterfly.c' \
        '*/drivers/spi/spi-bitbang-txrx.h'
mv drivers/gpio/gpio-sim.c gpio/sim.c
mv drivers/gpio/gpiolib.h kernel/irq/irq_sim.c gpio/
# The kernel does not export irq_to_desc. For a module this does the same.
sed -i 's/irq_to_desc(irqnum)/irq_data_to_desc(irq_get_irq_data(irqnum))/' gpio/irq_sim.c
mv drivers/net/can/ctucanfd/*.[ch] can/
mv drivers/pwm/pwm-pca9685.c pwm/
mv drivers/spi/spidev.c drivers/spi/spi-butterfly.c drivers/spi/spi-bitbang-txrx.h spi/
# As it is, each bit takes as long as its writes, whatever the rate. Here a byte takes the time of its
# rate: 16 half periods behind the byte before.
pace='static u64 end; u64 now = ktime_get_ns(); u32 in; end = (now > end ? now : end) + 16ULL * nsecs;'
pace="$pace in = bitbang_txrx_be_cpha0(spi, 0, 0, flags, word, bits);"
pace="$pace while (ktime_get_ns() < end) cpu_relax(); return in;"
sed -i "s|return bitbang_txrx_be_cpha0(spi, nsecs, 0, flags, word, bits);|$pace|" spi/spi-butterfly.c
grep -q '16ULL \* nsecs' spi/spi-butterfly.c
printf '%s\n' 'obj-m := gpio-sim.o' 'gpio-sim-y := sim.o irq_sim.o' >gpio/Kbuild
printf '%s\n' 'obj-m := ctucanfd.o ctucanfd_pci.o' 'ctucanfd-y := ctucanfd_base.o' >can/Kbuild
echo 'obj-m := pwm-pca9685.o' >pwm/Kbuild
echo 'obj-m := spidev.o spi-butterfly.o' >spi/Kbuild

modules="$kernel/lib/modules/$version/updates"
mkdir -p "$modules"
for folder in gpio can pwm spi; do
    make -C "usr/src/linux-headers-$version" M="$work/$folder" CC=gcc-12 modules >make.log 2>&1 || {
        cat make.log >&2
        exit 1
    }
    strip --strip-debug "$folder"/*.ko
    cp "$folder"/*.ko "$modules"
done
depmod --basedir "$kernel" "$version"
rm -rf "$work"
touch "$kernel/modules-built"
