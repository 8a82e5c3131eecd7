"""Renders the templates of a discovery message as Home Assistant does, for home_assistant_test.cpp.

Argument: a file with two lines, the discovery message and the status, both JSON. Prints a JSON object:
for each component the text of its template. Home Assistant renders in Jinja's immutable sandbox, with
the message as `value_json` (its documentation of MQTT sensors).
"""

import json
import sys

from jinja2.sandbox import ImmutableSandboxedEnvironment


def main():
    with open(sys.argv[1], encoding="utf-8") as lines:
        discovery, status = (json.loads(line) for line in lines)
    environment = ImmutableSandboxedEnvironment()
    print(
        json.dumps(
            {
                name: environment.from_string(component["value_template"]).render(value_json=status)
                for name, component in discovery["components"].items()
                if "value_template" in component
            }
        )
    )


main()
