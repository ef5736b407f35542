"""A stand-in for what Pyblish and AYON document of plugins and publishing, and a publish to try a gate with."""

# What Pyblish documents of plugins, contexts and publishing, as far as a gate needs it.
STAND_IN = {"__init__.py": "", "api.py": '''
import importlib.util, inspect, logging, os
CollectorOrder, ValidatorOrder, ExtractorOrder, IntegratorOrder = 0, 1, 2, 3
registered = []

class Plugin:
    families, order, label, optional = ["*"], -1, None, False
    @property
    def log(self):
        return logging.getLogger("pyblish." + type(self).__name__)

class ContextPlugin(Plugin):
    pass

class InstancePlugin(Plugin):
    pass

class Instance(list):
    def __init__(self, name, context, **data):
        self.name, self.context, self.data = name, context, {"name": name, "family": "default", **data}

class Context(list):
    def __init__(self):
        self.data = {}
    def create_instance(self, name, **data):
        self.append(Instance(name, self, **data))
        return self[-1]

def register_plugin(plugin):
    registered.append(plugin)

def discover():
    found = list(registered)
    for folder in os.environ.get("PYBLISHPLUGINPATH", "").split(os.pathsep):
        for name in sorted(os.listdir(folder)):
            if name.endswith(".py") and not name.startswith("_"):
                spec = importlib.util.spec_from_file_location(name[:-3], os.path.join(folder, name))
                module = importlib.util.module_from_spec(spec)
                spec.loader.exec_module(module)
                found += [each for _, each in inspect.getmembers(module, inspect.isclass)
                          if issubclass(each, Plugin) and each not in (Plugin, ContextPlugin, InstancePlugin)]
    return sorted(found, key=lambda each: each.order)
''', "util.py": '''
import logging
from . import api

class Keep(logging.Handler):
    def emit(self, record):
        self.kept.append(record)

def publish():
    context = api.Context()
    context.data["results"] = []
    failed = False
    for Plugin in api.discover():
        if failed and Plugin.order >= 1.5:  # only validators stop what follows
            break
        for instance in ([None] if issubclass(Plugin, api.ContextPlugin) else list(context)):
            if instance is not None and instance.data.get("publish") is False:
                continue
            if instance is not None and "*" not in Plugin.families and not (
                    {instance.data["family"], *instance.data.get("families", [])} & set(Plugin.families)):
                continue
            keep, error = Keep(), None
            keep.kept = []
            logging.getLogger().addHandler(keep)
            try:
                Plugin().process(context if instance is None else instance)
            except Exception as raised:
                error, failed = raised, failed or 0.5 <= Plugin.order < 1.5
            logging.getLogger().removeHandler(keep)
            context.data["results"].append({"plugin": Plugin, "error": error, "records": keep.kept})
    return context
'''}

# A publish: the studio's own collector, perhaps an extractor, the gate, and an integrator.
PUBLISH = '''
import json, logging, pathlib, sys
import pyblish.api, pyblish.util
logging.getLogger().setLevel(logging.DEBUG)
job = json.loads(sys.argv[1])

class CollectRig(pyblish.api.ContextPlugin):
    order = pyblish.api.CollectorOrder
    def process(self, context):
        context.data.update(job.get("context", {}))
        if "instance" in job:
            instance = context.create_instance("hero", family=job.get("family", "rig"))
            instance.data.update(job["instance"])

class ExtractRig(pyblish.api.InstancePlugin):
    order = pyblish.api.ExtractorOrder
    def process(self, instance):
        instance.data.update(job.get("extracted", {}))

class IntegrateRig(pyblish.api.InstancePlugin):
    order = pyblish.api.IntegratorOrder
    def process(self, instance):
        pathlib.Path("published").write_text(instance.data["name"])

for each in (CollectRig, ExtractRig, IntegrateRig):
    pyblish.api.register_plugin(each)
context = pyblish.util.publish()
print(json.dumps({
    "errors": [str(result["error"]) for result in context.data["results"] if result["error"]],
    "kinds": [type(result["error"]).__name__ for result in context.data["results"] if result["error"]],
    "warnings": [record.getMessage() for result in context.data["results"] for record in result["records"] if record.levelname == "WARNING"],
    "infos": [record.getMessage() for result in context.data["results"] for record in result["records"] if record.levelname == "INFO"],
    "outcomes": [instance.data.get("backbend_outcome", {}).get("kind") for instance in context]}))
'''

AYON = '''
class PublishValidationError(Exception):
    def __init__(self, message, title=None, description=None, detail=None):
        self.message, self.title, self.description = message, title, description or message
        super().__init__(json.dumps({"message": message, "title": title, "description": self.description}))
import json

class OptionalPyblishPluginMixin:
    def is_active(self, data):
        return data.get("active", True)
'''
