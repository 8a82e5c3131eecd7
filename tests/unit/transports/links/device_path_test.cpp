#include "transports/links/device_path.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace tribus::test::device_path_test {
namespace {

TEST(DeviceIdentity, IsThatOfTheDeviceThatALinkLeadsTo) {
    const TemporaryFolder folder;
    const std::string device = folder.write("ttyUSB0", "");
    std::filesystem::create_symlink(device, folder / "by-id");
    EXPECT_EQ(device_identity(folder / "by-id"), device_identity(device));
    EXPECT_NE(device_identity(folder.write("ttyUSB1", "")), device_identity(device));
}

TEST(DeviceIdentity, IsThePathWhereNoDeviceIs) {
    EXPECT_EQ(device_identity("/dev/./absent"), device_identity("/dev/absent"));
    EXPECT_NE(device_identity("/dev/absent"), device_identity("/dev/absent2"));
}

TEST(DeviceIdentity, IsNoPathWhereADeviceIs) {
    const TemporaryFolder folder;
    const std::string identity = device_identity(folder.write("ttyUSB0", ""));
    for (const std::string& path : {identity, identity.substr(1), identity.substr(2)}) {
        EXPECT_NE(device_identity(path), identity) << path;
    }
}

}  // namespace
}  // namespace tribus::test::device_path_test
