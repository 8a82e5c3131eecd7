#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/installed.h"

/// The package in a fresh Debian with systemd: installed, running on real drivers, supervised,
/// confined and removed. i.Bus in at a 16550, SBUS out at an FTDI adapter.
namespace tribus::test::systemd_service_test {
namespace {

TEST_F(InstalledPackage, HasAUserGroupsAndDevicesOfItsOwn) {
    EXPECT_NE(shell("id tribus").find("(tribus)"), std::string::npos);
    shell("getent group gpio uinput; modprobe uinput; udevadm settle");
    EXPECT_EQ(shell("stat -c %G:%a /dev/cpu_dma_latency /dev/uinput"), "tribus:660\nuinput:660\n");
    EXPECT_EQ(shell("id -nG tribus"), "tribus\n") << "a virtual keyboard is not for every daemon";
}

TEST_F(InstalledPackage, HasAProgramThatTakesEveryExample) {
    shell("install -d /etc/tribus/keys; tribus key new /etc/tribus/keys/boat.key");
    shell(
        "for file in /usr/share/doc/tribus/examples/*.toml; do tribus check \"$file\" || exit 1; "
        "done");
    shell("rm /etc/tribus/keys/boat.key");
}

TEST_F(InstalledPackage, HasAUnitThatIsRightAndClosed) {
    EXPECT_EQ(shell("systemd-analyze verify --man=no " + kUnit), "");
    shell("systemd-analyze security --no-pager --threshold=15 " + kUnit);
}

TEST_F(InstalledPackage, IsNotTriedAgainWhereItsConfigurationHasMistakes) {
    write_file(kConfigurations / "servos.toml", "[input.receiver]\nprotocol = \"ibis\"\n");
    EXPECT_NE(run_shell("systemctl start " + kUnit).status, 0);
    EXPECT_TRUE(becomes("ActiveState", "failed"));
    EXPECT_EQ(property("ExecMainStatus"), "2");
    EXPECT_NE(journal("-p err").find("/etc/tribus/servos.toml:2:12: "), std::string::npos)
        << journal();
}

TEST_F(InstalledPackage, WaitsAsLongAsItTakesForADeviceThatIsMissingAtItsStart) {
    unplug_usb(1);
    shell("systemctl start " + kUnit);
    EXPECT_TRUE(in_time([&] {
        return journal().find("there is no such device; is it plugged in?") != std::string::npos;
    })) << journal();
    plug_usb(1);
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_EQ(property("NRestarts"), "0");
}

/// A key file that only root may read, and a link over UDP that has it as a credential.
class KeyOfTheService : public InstalledPackage {
  protected:
    KeyOfTheService() {
        write_file(kFile, std::string(64, '7') + "\n");
        shell("chmod 600 " + kFile + "; ip link set lo up");
    }
    ~KeyOfTheService() override { shell("rm -r /etc/tribus/keys"); }

    static void start_with_key(const std::string& file) {
        write_file(kConfigurations / "servos.toml",
                   "[input.shore]\nprotocol = \"network\"\naddress = \"127.0.0.1:5700\"\nkey = \"" +
                       file + "\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"" +
                       ftdi_adapter(1) +
                       "\"\n[pipeline.main]\nfrom = \"shore\"\nto = \"servos\"\n");
        drop_in(kUnit,
                "[Service]\nRestrictAddressFamilies=AF_INET\nIPAddressAllow=localhost\n"
                "LoadCredential=boat.key:" +
                    kFile + "\n");
        run_shell("systemctl start " + kUnit);
    }

    static inline const std::string kFile = "/etc/tribus/keys/boat.key";
};

TEST_F(KeyOfTheService, MayBeACredential) {
    start_with_key("/run/credentials/" + kUnit + "/boat.key");
    EXPECT_TRUE(becomes("ActiveState", "active"));
    EXPECT_NE(journal().find("started /etc/tribus/servos.toml"), std::string::npos) << journal();
    EXPECT_EQ(journal().find("7777"), std::string::npos) << "the key";
}

TEST_F(KeyOfTheService, IsRefusedWithItsPlaceUntilTheServiceMayReadIt) {
    start_with_key(kFile);
    EXPECT_NE(journal("-p err").find("/etc/tribus/servos.toml:4:7: \"key\" is \"" + kFile +
                                     "\": Permission denied"),
              std::string::npos)
        << journal();
    shell("chgrp tribus-keys " + kFile + "; chmod 640 " + kFile);
    EXPECT_TRUE(becomes("ActiveState", "active")) << journal();
}

TEST_F(InstalledService, TranslatesIbusToSbus) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_TRUE(carries(1800, 1800)) << journal();
}

TEST_F(InstalledService, HasAllOfRealTime) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_EQ(journal("-p warning").find("no full real time"), std::string::npos) << journal();
}

TEST_F(InstalledService, TellsInItsStatusWhatGoesOn) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_TRUE(becomes("StatusText", "servos: under control of receiver; receiver: good"));
}

TEST_F(InstalledService, WritesLevelsIntoTheJournal) {
    const std::string started = "started /etc/tribus/servos.toml";
    EXPECT_EQ(journal("-t tribus -p info").rfind(started, 0), 0U) << journal();
    EXPECT_EQ(journal("-p notice").find(started), std::string::npos);
}

TEST_F(InstalledService, TellsTheJournalWhatEachEntryIsAbout) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_TRUE(in_time([&] {
        return journal("TRIBUS_INPUT=receiver TRIBUS_CAUSE=good") == "input receiver: good\n";
    })) << journal();
    EXPECT_TRUE(in_time([&] {
        return journal("TRIBUS_OUTPUT=servos TRIBUS_STATE=control") ==
               "output servos: under control of receiver\n";
    })) << journal();
}

TEST_F(InstalledService, TranslatesOnAReadOnlyRoot) {
    // As after a disk error, even though programs have files open.
    shell("systemctl stop " + kUnit + "; echo u > /proc/sysrq-trigger");
    EXPECT_TRUE(in_time([] { return run_shell("touch /var/lib/anything").status != 0; }));
    shell("systemctl start " + kUnit);
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_NE(run_shell("touch /var/lib/anything").status, 0) << "the root is not read-only";
    shell("mount -o remount,rw /");
}

TEST_F(InstalledService, TranslatesOnAFullDisk) {
    shell("systemctl stop " + kUnit + "; cat /dev/zero > /var/full; true");
    EXPECT_NE(run_shell("head -c 1000000 /dev/zero > /var/more").status, 0)
        << "the disk is not full";
    shell("systemctl start " + kUnit);
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    shell("rm /var/full /var/more");
}

TEST_F(InstalledService, GoesBackFromATrialByItself) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    configure("[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n");
    EXPECT_NE(shell("tribus reload servos --trial 2s < /dev/null 2>&1").find("taken, on trial"),
              std::string::npos);
    EXPECT_TRUE(carries(1200, 1800)) << journal();
    EXPECT_TRUE(carries(1200, 1200)) << journal();
}

TEST_F(InstalledService, ComesBackAfterItWasKilled) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    shell("systemctl kill -s KILL " + kUnit);
    EXPECT_TRUE(becomes("NRestarts", "1"));
    EXPECT_TRUE(carries(1800, 1800)) << journal();
}

TEST_F(InstalledService, ComesBackAfterItsDataThreadHung) {
    restart_with_hang_preload();
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    shell("systemctl kill -s USR2 " + kUnit);
    EXPECT_TRUE(becomes("NRestarts", "1")) << journal();
    EXPECT_TRUE(carries(1800, 1800)) << journal();
    EXPECT_NE(journal("-p err").find("the data thread stands still"), std::string::npos);
}

TEST_F(InstalledService, ComesBackAfterItsMainThreadHung) {
    restart_with_hang_preload();
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    shell("systemctl kill -s USR1 " + kUnit);
    EXPECT_TRUE(becomes("NRestarts", "1")) << journal();
    EXPECT_TRUE(carries(1800, 1800)) << journal();
}

TEST_F(InstalledService, TakesANewConfigurationWhenItIsReloaded) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    configure("[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n");
    shell("systemctl reload " + kUnit);
    EXPECT_TRUE(carries(1200, 1800)) << journal();
    EXPECT_TRUE(becomes("ActiveState", "active"));
    EXPECT_EQ(property("NRestarts"), "0");
}

TEST_F(InstalledService, GoesOnAfterAReloadThatWasRefused) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    configure("[pipeline.main.channels]\n1 = { form = 1 }\n");
    shell("systemctl reload " + kUnit);
    EXPECT_TRUE(carries(1800, 1800)) << journal();
    EXPECT_TRUE(becomes("ActiveState", "active"));
    EXPECT_NE(journal("-p err").find("reload refused"), std::string::npos) << journal();
}

TEST_F(InstalledService, LivesOnWhileItsPackageIsUpgraded) {
    const std::string process = property("MainPID");
    const std::string said = shell("dpkg -i " + kPackage);
    EXPECT_NE(said.find("running instances keep the old version"), std::string::npos) << said;
    EXPECT_EQ(property("MainPID"), process);
    EXPECT_TRUE(carries(1200, 1200)) << journal();
}

/// An instance that runs another program, which tries what is forbidden.
class Sandbox : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        install();
        tried_.emplace(
            "tribus@probe.service", "Restart=no\nWatchdogSec=0\nRuntimeDirectoryPreserve=yes\n",
            "/run/tribus/probe/tried", "try folder 'touch /run/tribus/probe/a && echo made'\n");
        shell("rm -r /run/tribus/probe");
    }

    static inline std::optional<TriedSandbox> tried_;
};

TEST_F(Sandbox, HasNoPrivileges) {
    EXPECT_EQ(tried_->of("rights"), kNoRights);
}

TEST_F(Sandbox, SeesNothingOfHomes) {
    EXPECT_TRUE(tried_->says("home", "cat: ")) << tried_->of("home");
    EXPECT_FALSE(tried_->says("home", "treasure")) << tried_->of("home");
}

TEST_F(Sandbox, WritesNowhereButIntoItsOwnFolder) {
    EXPECT_TRUE(tried_->says("system", "Read-only file system")) << tried_->of("system");
    EXPECT_EQ(tried_->of("folder"), "made ");
}

TEST_F(Sandbox, HasNoInternet) {
    EXPECT_TRUE(tried_->says("internet", "Address family not supported")) << tried_->of("internet");
}

TEST_F(Sandbox, OpensNoDeviceOfAnotherKind) {
    EXPECT_TRUE(tried_->says("disk", "Operation not permitted")) << tried_->of("disk");
}

TEST_F(Sandbox, MakesNoNamespaces) {
    EXPECT_TRUE(tried_->says("namespace", "Operation not permitted")) << tried_->of("namespace");
}

class CanExamples : public InstalledPackage {};

TEST_F(CanExamples, BringABusUp) {
    shell(
        "cp /usr/share/doc/tribus/examples/networkd/80-can* /etc/systemd/network/; "
        "rm /etc/systemd/network/80-can0-fd.network; "
        "driver=$(basename $(readlink -f /sys/class/net/can0/device/driver/module)); "
        "modprobe -r $driver; modprobe $driver; systemctl start systemd-networkd");
    EXPECT_TRUE(in_time([] {
        return shell("ip -details link show can0").find("bitrate 500000") != std::string::npos;
    })) << shell("ip -details link show can0; journalctl -q -u systemd-networkd");
    const std::string link = shell("ip -details link show can0");
    EXPECT_NE(link.find("restart-ms 100"), std::string::npos) << link;
    EXPECT_NE(link.find("qlen 16"), std::string::npos) << link;
    EXPECT_TRUE(in_time([] {
        return shell("ip link show can0").find(",UP,") != std::string::npos;
    })) << shell("ip link show can0");
}

/// This test is the last one, because it removes the package.
class RemovedPackage : public InstalledPackage {};

TEST_F(RemovedPackage, HasStoppedAndLeavesNothingButConfigurationsOfItsOwner) {
    shell("systemctl enable --now " + kUnit);
    shell("apt-get -q -y remove tribus");
    EXPECT_EQ(shell("pgrep tribus || true"), "");
    EXPECT_NE(shell("systemctl is-enabled " + kUnit + " 2>&1 || true"), "enabled\n");
    shell("apt-get -q -y purge tribus");
    EXPECT_EQ(shell("find / -xdev -name '*tribus*' -not -path '/var/cache/*' "
                    "-not -path '/host/*' -not -path '/var/log/*' | sort"),
              "/etc/tribus\n");
    EXPECT_EQ(shell("ls /etc/tribus"), "servos.toml\n");
    // As with other packages: the number of a removed user must not be given to another user.
    shell("id tribus");
}

}  // namespace
}  // namespace tribus::test::systemd_service_test
