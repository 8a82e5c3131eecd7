#include "config/show/json_schema.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/keys/keys.h"
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

using Json = nlohmann::ordered_json;

/// The same without descriptions, which are long.
Json bare(Json json) {
    if (!json.is_structured()) {
        return json;
    }
    if (json.is_object() && json.contains("description") && json["description"].is_string()) {
        json.erase("description");
    }
    for (Json& inside : json) {
        inside = bare(inside);
    }
    return json;
}

const Json& whole_schema() {
    static const Json kSchema = Json::parse(json_schema());
    return kSchema;
}

/// A part of the schema without descriptions.
std::string part(const std::string& pointer) {
    return bare(whole_schema().at(Json::json_pointer(pointer))).dump();
}

const std::string kNames = "/patternProperties/^[A-Za-z0-9_-]+$";
const std::string kPipeline = "/properties/pipeline" + kNames + "/properties";
const std::string kNumbers = R"("type":"object","additionalProperties":false,"patternProperties":)"
                             R"({"^([1-9]|1[0-8])$":)";

std::vector<std::string> keys_of(const Json& object) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : object.items()) {
        keys.push_back(key);
    }
    return keys;
}

TEST(JsonSchema, IsOneOfATableWithTheTablesOfAFile) {
    const Json& schema = whole_schema();
    EXPECT_EQ(schema["$schema"], "http://json-schema.org/draft-07/schema#");
    EXPECT_EQ(schema["title"], "Configuration of tribus");
    EXPECT_EQ(keys_of(schema), (std::vector<std::string>{"$schema", "title", "type",
                                                         "additionalProperties", "properties"}));
    EXPECT_EQ(
        keys_of(schema["properties"]),
        (std::vector<std::string>{"runtime", "input", "output", "pipeline", "gpio", "sensor_bus",
                                  "sensor_type", "values", "dronecan", "recorder"}));
    const std::string text = json_schema();
    EXPECT_EQ(text.substr(0, 15), "{\n  \"$schema\": ");
    EXPECT_TRUE(text.ends_with("}\n"));
}

TEST(JsonSchema, DescribesATable) {
    EXPECT_EQ(part("/properties/runtime"),
              R"({"type":"object","additionalProperties":false,"properties":{"realtime":{"enum":)"
              R"(["auto","off","require"],"default":"auto"},"priority":{"type":"integer",)"
              R"("minimum":1,"maximum":99,"default":80},"cpu":{"type":"integer","minimum":0,)"
              R"("maximum":255},"spin":{"type":"string","pattern":)"
              R"("^[0-9]+(\\.[0-9]+)?(us|ms|s)$","default":"0s"}}})");
    EXPECT_EQ(part(kPipeline + "/handover"),
              R"({"type":"object","additionalProperties":false,"properties":{"input":{"type":)"
              R"("string","minLength":1},"channel":{"type":"integer","minimum":1,"maximum":18}},)"
              R"("required":["input","channel"]})");
    EXPECT_EQ(part("/properties/pipeline" + kNames + "/required"), R"(["from","to"])");
    EXPECT_EQ(whole_schema()["properties"]["runtime"]["properties"]["cpu"]["description"],
              "Processor that the data thread is pinned to. Default: any processor");
}

TEST(JsonSchema, DescribesTablesWithNames) {
    const Json& gpio = whole_schema()["properties"]["gpio"];
    EXPECT_EQ(keys_of(gpio),
              (std::vector<std::string>{"description", "type", "additionalProperties",
                                        "patternProperties"}));
    EXPECT_EQ(gpio["additionalProperties"], false);
    EXPECT_EQ(part("/properties/gpio" + kNames + "/required"), R"(["line","role"])");
}

TEST(JsonSchema, DescribesNames) {
    EXPECT_EQ(part(kPipeline + "/from"),
              R"({"anyOf":[{"type":"string","pattern":"^[A-Za-z0-9_-]+$"},{"type":"array",)"
              R"("items":{"type":"string","pattern":"^[A-Za-z0-9_-]+$"},"minItems":1,)"
              R"("uniqueItems":true}]})");
}

TEST(JsonSchema, DescribesPresetsAndWeights) {
    EXPECT_EQ(part(kPipeline + "/failsafe/properties/preset"),
              "{" + kNumbers +
                  R"({"type":"number","minimum":500.0,"maximum":2500.0}},"properties":{"other":)"
                  R"({"type":"number","minimum":500.0,"maximum":2500.0}}})");
    EXPECT_EQ(
        part(kPipeline + "/channels/patternProperties/^([1-9]|1[0-8])$/anyOf/1/properties/mix"),
        "{" + kNumbers + R"({"type":"number","minimum":-10.0,"maximum":10.0}},"minProperties":1})");
}

TEST(JsonSchema, DescribesChannels) {
    const std::string channel = kPipeline + "/channels/patternProperties/^([1-9]|1[0-8])$/anyOf";
    EXPECT_EQ(part(channel + "/0"), R"({"type":"integer","minimum":1,"maximum":18})");
    EXPECT_EQ(part(channel + "/1/oneOf"),
              R"([{"required":["from"]},{"required":["mix"]},{"required":["fixed"]},)"
              R"({"required":["line"]}])");
    EXPECT_EQ(part(channel + "/1/additionalProperties"), "false");
    EXPECT_EQ(whole_schema().at(Json::json_pointer(channel)).size(), 2U);
    EXPECT_TRUE(part(kPipeline + "/channels").starts_with("{" + kNumbers));
}

TEST(JsonSchema, DescribesListsTextsAndLines) {
    const std::string sensor = part("/properties/sensor_bus" + kNames + "/properties/sensor");
    EXPECT_TRUE(sensor.starts_with(R"({"type":"array","items":{"type":"object","additionalProp)"));
    EXPECT_TRUE(sensor.ends_with(R"(,"required":["type"]}})")) << sensor;
    EXPECT_EQ(part("/properties/values" + kNames + "/properties/signals"),
              R"({"type":"object","additionalProperties":{"type":"string","minLength":1},)"
              R"("minProperties":1})");
    EXPECT_EQ(part("/properties/gpio" + kNames + "/properties/line"),
              R"({"anyOf":[{"type":"integer","minimum":0},{"type":"string","minLength":1}]})");
}

/// What the schema of inputs or outputs says of a protocol.
Json branch(const Json& port, std::string_view protocol) {
    for (const Json& one : port["allOf"]) {
        if (one["if"]["properties"]["protocol"]["const"] == protocol) {
            EXPECT_EQ(one["if"]["required"].dump(), R"(["protocol"])");
            return one["then"];
        }
    }
    return {};
}

Json port_of(const std::string& way) {
    return whole_schema()["properties"][way]["patternProperties"]["^[A-Za-z0-9_-]+$"];
}

TEST(JsonSchema, HasABranchForEachProtocolOfInputsAndOutputs) {
    for (const auto& [name, way] :
         {std::pair("input", SettingScope::input), std::pair("output", SettingScope::output)}) {
        const Json port = port_of(name);
        std::vector<std::string> branches;
        for (const Json& one : port["allOf"]) {
            branches.push_back(one["if"]["properties"]["protocol"]["const"]);
        }
        const auto names = protocol_names(way);
        EXPECT_EQ(branches, std::vector<std::string>(names.begin(), names.end()));
        EXPECT_EQ(port["properties"]["protocol"]["enum"].get<std::vector<std::string>>(), branches);
        EXPECT_EQ(port["required"].dump(), R"(["protocol"])");
    }
}

TEST(JsonSchema, AllowsTheKeysOfAProtocolAndForbidsThoseOfOthers) {
    const Json port = port_of("input");
    const auto expect_only = [&](std::string_view protocol, const std::vector<std::string>& own) {
        const Json then = branch(port, protocol);
        std::vector<std::string> allowed;
        for (const auto& [key, value] : then["properties"].items()) {
            EXPECT_TRUE(port["properties"].contains(key)) << key;
            EXPECT_EQ(port["properties"][key], true) << key;
            if (value.is_object()) {
                allowed.push_back(key);
            } else {
                EXPECT_EQ(value, false) << key;
            }
        }
        EXPECT_EQ(allowed, own) << protocol;
        EXPECT_GT(then["properties"].size(), 40U);
    };
    expect_only("ibus", {"device", "address", "public", "sender", "baud", "slots"});
    expect_only("gamepad", {"device", "grab", "axes", "buttons", "dead_man", "activity_timeout"});
    EXPECT_FALSE(port["properties"].contains("foreign_sender"));
    EXPECT_TRUE(port_of("output")["properties"].contains("foreign_sender"));
}

TEST(JsonSchema, RequiresOneOfThePlacesOfAProtocolOrItsOnlyOne) {
    const Json ibus = branch(port_of("input"), "ibus");
    EXPECT_EQ(ibus["oneOf"].dump(), R"([{"required":["device"]},{"required":["address"]}])");
    EXPECT_FALSE(ibus.contains("required"));
    const Json can = branch(port_of("input"), "can");
    EXPECT_EQ(can["required"].dump(), R"(["interface"])");
    EXPECT_FALSE(can.contains("oneOf"));
    const Json joystick = branch(port_of("output"), "joystick");
    EXPECT_EQ(joystick["required"].dump(), R"(["name"])");
}

}  // namespace
}  // namespace tribus::test::json_schema_test
