#include "config/show/json_schema.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/unit/config/examples.h"

namespace tribus::test::json_schema_test {
namespace {

TEST(JsonSchema, OffersTheKeysOfAProtocolToItsTablesOnly) {
    const auto schema = nlohmann::json::parse(json_schema());
    const auto& input = schema.at("/properties/input/patternProperties"_json_pointer).front();
    for (const auto& branch : input.at("allOf")) {
        const auto& protocol = branch.at("/if/properties/protocol/const"_json_pointer);
        EXPECT_EQ(branch.at("/then/properties/slots"_json_pointer).is_object(), protocol == "ibus");
        const bool has_sbus_channels =
            protocol == "sbus" || protocol == "fport" || protocol == "fport2" || protocol == "fbus";
        EXPECT_EQ(branch.at("/then/properties/scale"_json_pointer).is_object(),
                  has_sbus_channels || protocol == "dsm" || protocol == "dronecan");
        EXPECT_EQ(branch.at("/then/properties/signals"_json_pointer).is_object(),
                  protocol == "dbc");
    }
}

/// Runs Debian's Python, which has a validator in python3-jsonschema.
int python(const std::string& script) {
    return std::system(("/usr/bin/python3 -W ignore -c '" + script + "'").c_str());
}

TEST(JsonSchema, AcceptsTheExamplesAndRefusesAWrongKey) {
    if (python("import jsonschema, tomllib") != 0) {
        GTEST_SKIP() << "needs /usr/bin/python3 of 3.11 or later with python3-jsonschema";
    }
    const std::string folder = config_folder().string();
    TemporaryFolder own;
    own.write("tribus.schema.json", json_schema());
    EXPECT_EQ(python(R"(
import glob, json, jsonschema, tomllib
schema = json.load(open(")" +
                     (own / "tribus.schema.json") + R"("))
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
files = glob.glob(")" +
                     folder +
                     R"(/examples/*.toml")
assert files
for name in files:
    document = tomllib.load(open(name, "rb"))
    validator.validate(document)
    table = document.get("pipeline", document.get("sensor_bus"))
    next(iter(table.values()))["form"] = "receiver"
    assert not validator.is_valid(document), name
)"),
              0);
}

}  // namespace
}  // namespace tribus::test::json_schema_test
