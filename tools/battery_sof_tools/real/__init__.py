"""Laws that no catalogue has, put into recordings that were measured: is their family named, and nothing else?"""
