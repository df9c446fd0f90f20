# SPDX-License-Identifier: Apache-2.0
"""Conditions between the options of several programs that [[clash]] of configs/pipeline.toml declares."""

import ast
import operator

from nightmap_site.toml_file import PipelineError

OPERATORS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
             ast.Gt: operator.gt, ast.Lt: operator.lt, ast.GtE: operator.ge, ast.LtE: operator.le}  # fmt: skip


def check_clashes(clashes, configs):
    """Raises PipelineError when a declared clash holds; names the place of every value in it."""
    wrong = []
    for clash in clashes:
        names = []
        tree = ast.parse(clash["when"], mode="eval").body
        programs = {node.value.id for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)}
        if not programs <= set(configs):
            continue  # the profile leaves one of the programs out
        if _value(tree, configs, names):
            values = [f"{program}.{key} = {configs[program].values[key]} ({configs[program].place_of(key)})" for program, key in names]
            wrong.append(f"{'; '.join(dict.fromkeys(values))}: {clash['remedy']}")
    if wrong:
        raise PipelineError("\n".join(wrong))


def _value(node, configs, names):
    """The value of an expression of numbers, PROGRAM.KEY, + - * / and comparisons."""
    match node:
        case ast.Constant():
            return node.value
        case ast.BinOp():
            return OPERATORS[type(node.op)](_value(node.left, configs, names), _value(node.right, configs, names))
        case ast.Compare(ops=[op], comparators=[right]):
            return OPERATORS[type(op)](_value(node.left, configs, names), _value(right, configs, names))
        case ast.BoolOp(op=ast.And()):
            return all(_value(part, configs, names) for part in node.values)
        case ast.Attribute(value=ast.Name(id=program), attr=key):
            names.append((program, key))
            return configs[program].values[key]
    raise PipelineError(f"configs/pipeline.toml: clash: cannot evaluate {ast.unparse(node)}")
